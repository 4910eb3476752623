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
# All that is downloaded must have its hash; code of it is not run.
RUN python -m pip install --no-cache-dir --require-hashes --only-binary :all: \
        --requirement /source/harness/drivegate/templates/new/every/requirements.txt \
    && python -m pip install --no-cache-dir --no-deps --no-build-isolation /source \
    && rm -rf /source

# Compiled once, here, and closed to all others: who runs the image copies it, and compiles again on another processor.
# PYTHONSAFEPATH: Python does not search the folder that a candidate is in.
ENV DRIVEGATE_CACHE=/var/cache/drivegate HOME=/tmp PYTHONSAFEPATH=1
RUN python -m drivegate.gate.warm_up && chmod -R a+rX,go-w /var/cache/drivegate

USER 65534:65534
WORKDIR /work
CMD ["drivegate", "--help"]
