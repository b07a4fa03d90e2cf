// Worlds of RIB scenes under libFuzzer; built and run by tests/fuzz/run.
#include "fuzz/rib_mutator.h"
#include "fuzz/world_input.h"

#define KN_FUZZ_READ(text) buildWorldInput(text)
#define KN_FUZZ_MUTATOR RibMutator
#include "fuzz/text_entry.h"
