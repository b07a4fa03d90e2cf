// The shading language's front end under libFuzzer; built and run by tests/fuzz/run.
#include "fuzz/osl_input.h"
#include "fuzz/osl_mutator.h"

#define KN_FUZZ_READ(text) compileOslInput(text)
#define KN_FUZZ_MUTATOR OslMutator
#include "fuzz/text_entry.h"
