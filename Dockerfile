# drivegate with a C compiler and the compiled plant, for CI jobs and for candidates that nobody should trust.
FROM python:3.12-slim

# Candidates in C are compiled where they are checked.
RUN apt-get update \
    && apt-get install --yes --no-install-recommends gcc libc6-dev \
    && rm -rf /var/lib/apt/lists/*

COPY pyproject.toml hatch_build.py README.md LICENSE /source/
COPY models /source/models
COPY reference_cases /source/reference_cases
COPY harness /source/harness
COPY reports /source/reports
COPY lab /source/lab
RUN python -m pip install --no-cache-dir /source pytest && rm -rf /source

# Compiled once, here, and closed to all others: who runs the image copies it, and compiles again on another processor.
ENV DRIVEGATE_CACHE=/var/cache/drivegate HOME=/tmp
RUN python -m drivegate.gate.warm_up && chmod -R a+rX,go-w /var/cache/drivegate

USER 65534:65534
WORKDIR /work
CMD ["drivegate", "--help"]
