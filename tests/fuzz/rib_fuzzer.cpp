// The RIB reader under libFuzzer; built and run by tests/fuzz/run.
#include "fuzz/rib_input.h"
#include "fuzz/rib_mutator.h"

#define KN_FUZZ_READ(text) readRibInput(text)
#define KN_FUZZ_MUTATOR RibMutator
#include "fuzz/text_entry.h"
