// PxrSeExpr's translator and what it hands on under libFuzzer; built and run by tests/fuzz/run.
#include "fuzz/seexpr_input.h"
#include "fuzz/seexpr_mutator.h"

#define KN_FUZZ_READ(text) runSeExprInput(text)
#define KN_FUZZ_MUTATOR SeExprMutator
#include "fuzz/text_entry.h"
