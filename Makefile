# Short names for daily work; each does nothing when there is nothing to do.
.PHONY: help deps test-deps r-deps r-package r-source test-r check-r configure configure-tests build demo test fuzz attack sanitize sanitize-threads tidy coverage bench-deps bench scorecard docs package check-package release mpi static test-static windows test-windows python-package test-python check-python format check-format clean

help:
	@echo "make demo    install what is missing, build the program, and run a whole study on the example"
	@echo "make build   the program, at build/bin/silvafit"
	@echo "make test    install what tests need, build them and the program, and run every test"
	@echo "make sanitize, make sanitize-threads, make tidy, make coverage   slower looks at the code, each in a build-* of its own"
	@echo "make fuzz SECONDS=60   every reader of files with libFuzzer, so many seconds each"
	@echo "make attack SECONDS=600   all commands on changed inputs, so many seconds"
	@echo "make r-package   the package for R, installed into build/r-library; make test-r runs its tests"
	@echo "make r-source    its source package, which needs no installed libraries, in build/r-source; make check-r runs R CMD check"
	@echo "make bench   speed, beside R where it is installed (make bench-deps installs it); docs/benchmarks.md"
	@echo "make scorecard   many fits beside their best known log-likelihoods; writes the tables of docs/scorecard.md"
	@echo "make mpi     the program for mpirun, at build-mpi/bin/silvafit (docs/large-inventories.md)"
	@echo "make static  the program as one file for any Linux, at build-static/bin/silvafit; make test-static tries it in an empty folder"
	@echo "make windows the program as one file for Windows, at build-windows/silvafit.exe, and as a ZIP file with the examples; make test-windows compares it in Wine"
	@echo "make docs    the documentation as a site, at build/site/index.html"
	@echo "make package .deb, their source package and .tar.gz, below build/; make check-package tries them in a clean Debian 12"
	@echo "make release all files of a release with their sums, in build/release (docs/download.md)"
	@echo "make python-package   the Python package: wheel and source package in build/dist, installed into build/python; make test-python tests it,"
	@echo "             make check-python tries the wheel in a clean Debian 12"
	@echo "make format  rewrite the sources as .clang-format says"

deps:
	@./scripts/install-dependencies

test-deps: deps
	@./scripts/install-dependencies packages/debian12-test.txt
	@./scripts/install-dependencies packages/debian12-gis.txt
	@./scripts/install-dependencies packages/debian12-mpi.txt

configure: deps
	@test -f build/build.ninja || cmake --preset release -DSILVAFIT_BUILD_TESTS=OFF

configure-tests: test-deps
	@grep -qs SILVAFIT_BUILD_TESTS:BOOL=ON build/CMakeCache.txt && grep -qs SILVAFIT_MPI:BOOL=ON build/CMakeCache.txt || \
	  cmake --preset release -DSILVAFIT_BUILD_TESTS=ON -DSILVAFIT_MPI=ON

build: configure
	@cmake --build --preset release

demo: build
	@build/bin/silvafit study examples/fir-mixed/inventory.csv --out build/demo

test: configure-tests
	@cmake --build --preset release-tests
	@ctest --preset release -j 2

r-deps: deps
	@./scripts/install-dependencies packages/debian12-r.txt

r-package: r-deps build
	@./scripts/r-package

test-r: r-package
	@./scripts/test-r

# Uses the pages of build/ and the options of build/r.makevars.
r-source: r-package
	@./scripts/install-dependencies packages/debian12-static.txt
	@./scripts/r-source

check-r: r-source
	@./scripts/check-r

# The presets leave out the tests that mostly run npm, Chromium or the compiler; a whole study stands in for them.
sanitize: test-deps
	@cmake --preset asan-ubsan && cmake --build --preset asan-ubsan && ctest --preset asan-ubsan -j 2
	@build-asan-ubsan/bin/silvafit study examples/fir-mixed/inventory.csv --out build-asan-ubsan/study

sanitize-threads: test-deps
	@cmake --preset tsan && cmake --build --preset tsan && ctest --preset tsan -j 2

tidy: test-deps
	@./scripts/install-dependencies packages/debian12-tidy.txt
	@cmake --preset tidy && cmake --build --preset tidy

# Every reader of files from elsewhere, so many seconds each; docs/hardening.md.
fuzz: test-deps
	@./scripts/install-dependencies packages/debian12-tidy.txt
	@cmake --preset fuzz && cmake --build --preset fuzz
	@scripts/fuzz $(or $(SECONDS),60)

# All commands on changed inputs; what is found is kept in build/attack. docs/hardening.md.
attack: build
	@tests/attack/attack.py build/bin/silvafit --seconds $(or $(SECONDS),600) --seed $(or $(SEED),1)

coverage: test-deps
	@cmake --preset coverage && cmake --build --preset coverage && ctest --preset coverage -j 2
	@build-coverage/bin/silvafit study examples/fir-mixed/inventory.csv --out build-coverage/study
	@./scripts/coverage build-coverage

bench-deps: deps
	@./scripts/install-dependencies packages/debian12-bench.txt

bench: deps
	@bench/run

# Twenty minutes on two processors; docs/scorecard.md.
scorecard: build
	@bench/scorecard/scorecard.py --out build/scorecard/results.csv >build/scorecard.md
	@bench/scorecard/scorecard.py --page build/scorecard/results.csv

# The program for jobs of several processes, build-mpi/bin/silvafit. docs/large-inventories.md.
mpi: deps
	@./scripts/install-dependencies packages/debian12-mpi.txt
	@cmake --preset mpi && cmake --build --preset mpi

# The program as one file, build-static/bin/silvafit. docs/download.md.
static: deps
	@./scripts/install-dependencies packages/debian12-static.txt
	@./scripts/static-libraries build-static/libraries
	@cmake --preset static && cmake --build --preset static

# Skipped where the sources of the static libraries cannot be fetched.
test-static: build
	@./scripts/install-dependencies packages/debian12-static.txt
	@status=0; ./scripts/static-libraries build-static/libraries || status=$$?; \
	  if [ $$status = 77 ]; then echo "skipped: the static program"; exit 0; fi; \
	  [ $$status = 0 ] && cmake --preset static && cmake --build --preset static && ./scripts/test-static

# The program as one file for Windows, build-windows/silvafit.exe, and with the examples as a ZIP file. docs/download.md.
windows: deps
	@./scripts/install-dependencies packages/debian12-windows.txt
	@./scripts/static-libraries build-windows/libraries cmake/windows.cmake
	@cmake --preset windows && cmake --build --preset windows
	@x86_64-w64-mingw32-strip -o build-windows/silvafit.exe build-windows/bin/silvafit.exe
	@cd build-windows && rm -rf silvafit silvafit.zip && mkdir silvafit && \
	  cp -r silvafit.exe ../LICENSE ../examples silvafit && awk '/^## / { keep = /Windows$$/ && !/macOS/ } keep' ../docs/download.md >silvafit/READ-ME.txt && zip -qr silvafit.zip silvafit

test-windows: build windows
	@./scripts/test-windows

package: build
	@./scripts/install-dependencies packages/debian12-package.txt
	@cd build && cpack
	@./scripts/debian-source

# All files of a release, in build/release; docs/download.md. The static program compiles everything anew and is therefore tried here, not in .ci/run.
release: static test-static windows package python-package r-source
	@./scripts/release

check-package: build
	@./scripts/install-dependencies packages/debian12-package.txt
	@./scripts/check-package

# docs/python.md
python-package: configure
	@./scripts/install-dependencies packages/debian12-python.txt
	@./scripts/install-dependencies packages/debian12-static.txt
	@./scripts/python-package

test-python: python-package
	@cmake --build build --target silvafit
	@PYTHONPATH=$(CURDIR)/build/python /usr/bin/python3 -m pytest -q -p no:cacheprovider bindings/python/tests

check-python: python-package
	@./scripts/install-dependencies packages/debian12-package.txt
	@./scripts/check-python

docs:
	@./scripts/install-dependencies packages/debian12-docs.txt
	@./scripts/build-site

format: test-deps
	@git ls-files '*.cpp' '*.hpp' | xargs clang-format -i

check-format: test-deps
	@git ls-files '*.cpp' '*.hpp' | xargs clang-format --dry-run --Werror

clean:
	@rm -rf build build-*
