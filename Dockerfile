# Image with Lodestar and Mesa's Vulkan drivers, which render on a CPU or on a GPU of AMD or Intel.
#
#   docker build -t lodestar .
#   docker run --rm -v "$PWD:/work" lodestar render scene.xml -o picture.png
#
# docs/packages.md says what a GPU needs.
#
# The base images are named by tags, because a tag gets the distribution's security updates, and a digest in this file would keep an
# old Mesa and old libraries until somebody changes it. An image that must be built again bit by bit names digests:
#
#   docker build --build-arg RUST=rust@sha256:DIGEST --build-arg BASE=debian@sha256:DIGEST -t lodestar .
ARG RUST=rust:1-bookworm
ARG BASE=debian:trixie-slim
FROM ${RUST} AS builder
WORKDIR /lodestar
COPY . .
RUN ./setup.sh
RUN CARGO_ENCODED_RUSTFLAGS="$(packages/remap.sh)" CARGO_PROFILE_RELEASE_DEBUG=0 CARGO_PROFILE_RELEASE_STRIP=symbols cargo build --release --locked --bin lodestar

# Mesa of trixie renders faster than that of bookworm.
FROM ${BASE}
RUN apt-get update \
    && apt-get install -y --no-install-recommends libvulkan1 libxext6 mesa-vulkan-drivers \
    && rm -rf /var/lib/apt/lists/*
COPY --from=builder /lodestar/target/release/lodestar /usr/local/bin/lodestar
# The NVIDIA container runtime mounts its Vulkan driver only if a container asks for graphics. The driver needs libxext6.
ENV NVIDIA_DRIVER_CAPABILITIES=graphics,compute,utility
WORKDIR /work
ENTRYPOINT ["lodestar"]
CMD ["--help"]
