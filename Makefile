# SPDX-License-Identifier: Apache-2.0
# Thin front of CMake; `make demo` and `make test` are all a new user needs.
CAPTURES := $(or $(FRINGETWIN_CAPTURES),$(abspath $(CURDIR)/../shared/captures))
JOBS ?= $(shell nproc)
OUT ?= out

# $(call configured,PRESET,FOLDER): quiet unless it fails; the log goes with the build.
configured = mkdir -p $(2) && cmake --preset $(1) >$(2)/configure.log 2>&1 || { cat $(2)/configure.log; exit 2; }

.PHONY: help deps configure program package build demo captures test test-all fuzz trust trust-refine real mesa25 test-mesa25 asan separate tidy format-check format studies site bench clean
help:
	@echo "make demo      install packages, build, run the paper's sphere, another renderer's images with a right and a wrong twin"
	@echo "               (and a real capture if present), list the reports in out/index.html"
	@echo "make captures  the public real captures from their repositories, checked, into $(CAPTURES)"
	@echo "make test      everything CI runs (format, includes, unit, accuracy, real data, end to end, sanitizers)"
	@echo "make test-all  the same, the long statistical tests, the benchmarks and every file compiled on its own"
	@echo "make fuzz MINUTES=10   changed inputs into every reader of foreign files, with the sanitizers, on all cores"
	@echo "make trust     rigs of known truth through the program; writes the tables of docs/TRUST.md (some minutes)"
	@echo "make trust-refine   a part of those rigs with groups of their twins refined; writes that table of docs/TRUST.md"
	@echo "make real      the program on the real captures that are here; writes docs/REAL_RIGS.md (some minutes)"
	@echo "make mesa25    a newer, faster software driver beside the system's; test-mesa25: the device tests on it"
	@echo "make studies   the studies of docs/STUDIES.md with their pages (half an hour)"
	@echo "make site      README.md and docs/ as a static site that can be searched, out/site/index.html; no network"
	@echo "make tidy      clang-tidy over DIRS=\"twin cli\": naming rules, bug patterns (slow)"
	@echo "make package   the Debian packages of the program, of its libraries and of the Python module, in build/"
	@echo "make build | program | bench | format | clean"

deps:
	@scripts/install_packages.sh

configure: deps
	@$(call configured,release,build)

# The program alone, without tests and benchmarks.
program: configure
	@cmake --build build -j $(JOBS) --target fringetwin_binary

# The Debian packages, in build/: what each has is in docs/PACKAGES.md. Their names are printed.
package: configure
	@cmake --build build -j $(JOBS) --target packaged
	@cmake -E chdir build cpack >build/package.log 2>&1 || { cat build/package.log; exit 2; }
	@sed -n 's/^CPack: - package: .*\/\(build\/.*\.deb\) generated\.$$/\1/p' build/package.log

build: configure
	@cmake --build build -j $(JOBS)

demo: program
	@scripts/demo.sh "$(OUT)" "$(CAPTURES)"

# Real captures: what is there already is compared, never overwritten.
captures:
	@scripts/get_captures.sh --target "$(CAPTURES)"

# Unit tests with the sanitizers only, all others as released: `make test-all` has both. Their build begins beside the
# released tests, which wait much for devices, workers and virtual machines: it takes only the time that these leave. A
# group of its own, so that it ends with them.
test: configure format-check
	@cmake --build build -j $(JOBS) --target tested
	@$(call configured,asan,build-asan)
	@setsid nice -n 19 cmake --build build-asan -j $(JOBS) --target unit_tests >build-asan/beside.log 2>&1 & beside=$$!; \
	 end_beside() { kill -- -$$beside 2>/dev/null; }; trap end_beside INT TERM; \
	 scripts/run_tests.sh build -LE "slow|unit"; status=$$?; \
	 if [ $$status -ne 0 ]; then end_beside; fi; wait $$beside; exit $$status
	@$(MAKE) --no-print-directory asan

test-all: build format-check separate
	@scripts/run_tests.sh build
	@$(MAKE) --no-print-directory asan

# Every rig of the battery; the page is written also where some fail, and make then says so.
trust: program
	@tests/trust/battery.py --program build/fringetwin --out "$(OUT)/trust" --page docs/TRUST.md

# Every real capture set that is here, with its best twin; writes the table of docs/REAL_RIGS.md.
real: program
	@FRINGETWIN_CAPTURES="$(CAPTURES)" scripts/real_rigs.py --program build/fringetwin --out "$(OUT)/real" --page docs/REAL_RIGS.md

trust-refine: program
	@tests/trust/battery.py --refine --program build/fringetwin --out "$(OUT)/trust-refine" --page docs/TRUST.md

asan: deps
	@$(call configured,asan,build-asan)
	@cmake --build build-asan -j $(JOBS) --target unit_tests
	@scripts/run_tests.sh build-asan -L unit

# Readers of foreign files under inputs changed at random; what ran new code is kept for the next time, what broke a
# reader is in build-fuzz/findings. SEED: the same changes again.
MINUTES ?= 10
SEED ?= $(shell date +%s)
fuzz: deps
	@$(call configured,fuzz,build-fuzz)
	@cmake --build build-fuzz -j $(JOBS) --target fuzz_readers
	@echo "seed $(SEED)"
	@build-fuzz/tests/fuzz_readers --source . --seconds $$(($(MINUTES) * 60 * $(JOBS))) --jobs $(JOBS) --seed $(SEED) \
	  --corpus build-fuzz/corpus --out build-fuzz/findings

# Debian's newer software driver, unpacked beside the system's (nothing is installed), and the device tests on it.
mesa25:
	@scripts/get_mesa25.sh

test-mesa25: configure
	@cmake --build build -j $(JOBS) --target tested
	@export $$(scripts/get_mesa25.sh) && scripts/run_tests.sh build -L device -LE slow

# Naming rules and bug patterns (.clang-tidy); slow, so no part of `make test`. DIRS: folders to look at.
DIRS ?= twin cli
tidy: separate
	@scripts/tidy.sh build-dev $(DIRS)

# Every file on its own, as one works on the code (preset dev): the release compiles several as one (FRINGETWIN_UNITY),
# which hides a missing include.
separate: deps
	@$(call configured,dev,build-dev)
	@cmake --build build-dev -j $(JOBS) --target fringetwin_binary unit_tests whole_tests

format-check:
	@scripts/check_format.sh

format:
	@git ls-files '*.cpp' '*.hpp' | xargs clang-format -i

# The shipped studies; draws the pictures of docs/STUDIES.md anew.
studies: program
	@scripts/studies.sh "$(OUT)/studies"

# The documents as a site; it is read as files, without a server.
site: deps
	@scripts/site.sh "$(OUT)/site"

bench: build
	@build/bench/bench_render
	@build/bench/bench_embree
	@build/bench/bench_povray
	@build/bench/bench_ray_query  # one line where the driver has none
	@build/bench/bench_scaling
	@build/bench/bench_sensor
	@build/bench/bench_study
	@build/bench/bench_compare
	@build/bench/bench_capture
	@if [ -d build/python/fringetwin ]; then bench/bench_python.py; fi  # where its module was built
	@scripts/bench_chain.sh   # per stage: render, decode, match, triangulate, fit; the whole against its bound

clean:
	rm -rf build build-asan build-debug build-dev build-fuzz build-separate out
