// Reader of .oso files and the machine that runs them under libFuzzer; built and run by tests/fuzz/run.
#include "fuzz/oso_input.h"
#include "fuzz/oso_mutator.h"

#define KN_FUZZ_READ(text) runOsoInput(text)
#define KN_FUZZ_MUTATOR OsoMutator
#include "fuzz/text_entry.h"
