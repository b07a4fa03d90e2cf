// The reader of IES profiles under libFuzzer; built and run by tests/fuzz/run.
#include "fuzz/ies_input.h"
#include "fuzz/ies_mutator.h"

#define KN_FUZZ_READ(text) readIesInput(text)
#define KN_FUZZ_MUTATOR IesMutator
#include "fuzz/text_entry.h"
