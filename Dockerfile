# silvafit in a container, from the Debian package that `make package` makes; docs/download.md says how to use it.
FROM debian:12-slim
COPY build/silvafit_*.deb /tmp/
# Slim images leave out what packages bring to read; the examples stay.
RUN echo 'path-include=/usr/share/doc/silvafit/examples/*' >/etc/dpkg/dpkg.cfg.d/silvafit \
 && apt-get update -qq \
 && apt-get install -y -qq --no-install-recommends /tmp/silvafit_*.deb \
 && rm -rf /tmp/silvafit_*.deb /var/lib/apt/lists/*
ENV LANG=C.UTF-8
# The folder of the host is mounted here.
WORKDIR /data
ENTRYPOINT ["silvafit"]
CMD ["--help"]
