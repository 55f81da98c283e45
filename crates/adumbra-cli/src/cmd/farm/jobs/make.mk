# Written by `adumbra plan --export make`. Run it (as many shards at once as -j says):
#   make -j2 -f THIS
# Safe to interrupt and to run again: what is in the cache folder is skipped.
export ADUMBRA_PROGRAM := @PROGRAM@
export ADUMBRA_PLAN := @PLAN@
export ADUMBRA_CACHE := @CACHE@
export ADUMBRA_OUTPUT := @OUTPUT@
SHARDS := @SHARDS@
export TRIES ?= 5
export RETRY_WAIT ?= 30

SHELL := /bin/sh
.SUFFIXES:
MAKEFLAGS += --no-builtin-rules
ids := $(shell i=0; while [ $$i -lt $(SHARDS) ]; do echo $$i; i=$$((i + 1)); done)
tiles := $(ids:%=tile-%)
# Run the words of $(1) by the shell; while it says "try again later" (75), up to TRIES times.
again = @try=1; while :; do rc=0; $(1) || rc=$$?; \
  if [ $$rc -ne 75 ] || [ $$try -ge "$$TRIES" ]; then exit $$rc; fi; \
  echo "$@: try again later ($$try of $$TRIES)" >&2; try=$$((try + 1)); sleep "$$RETRY_WAIT"; done

.PHONY: link $(tiles)
link: $(tiles)
	$(call again,"$$ADUMBRA_PROGRAM" link --plan "$$ADUMBRA_PLAN" --cache "$$ADUMBRA_CACHE" -o "$$ADUMBRA_OUTPUT"@THREADS@)
$(tiles): tile-%:
	$(call again,"$$ADUMBRA_PROGRAM" tile --plan "$$ADUMBRA_PLAN" --cache "$$ADUMBRA_CACHE" --shard $*/$(SHARDS)@THREADS@)
