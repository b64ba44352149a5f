# Short names for daily work; each does nothing when there is nothing to do.
.PHONY: help deps configure build demo test format check-format clean

help:
	@echo "make demo    install what is missing, build, and run a whole study on the example"
	@echo "make test    the same, and run every test"
	@echo "make build   the program, at build/bin/silvafit"
	@echo "make format  rewrite the sources as .clang-format says"

deps:
	@./scripts/install-dependencies

configure: deps
	@test -f build/build.ninja || cmake --preset release

build: configure
	@cmake --build --preset release

demo: build
	@build/bin/silvafit study examples/fir-mixed/inventory.csv --out build/demo

test: build
	@ctest --preset release -j 2

format:
	@git ls-files '*.cpp' '*.hpp' | xargs clang-format -i

check-format:
	@git ls-files '*.cpp' '*.hpp' | xargs clang-format --dry-run --Werror

clean:
	@rm -rf build build-*
