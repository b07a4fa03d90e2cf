// How functions of the C interface that end with a parameter list are written: once, for both of their forms.
#pragma once
#include "rib/ri/stream.h"

// KINORA_RI(RiName, last, (its arguments), their declarations) { ... } defines RiNameV, whose body sees n, tokens and
// values, and RiName, which takes pairs behind `last` and calls it.
#define KINORA_RI_WORDS(...) __VA_ARGS__
#define KINORA_RI_OF(RESULT, NAME, LAST, ARGUMENTS, ...)                                      \
  RESULT NAME(__VA_ARGS__, ...) {                                                             \
    va_list list;                                                                             \
    va_start(list, LAST);                                                                     \
    kinora::rib::ri::Pairs pairs(list);                                                       \
    va_end(list);                                                                             \
    return NAME##V(KINORA_RI_WORDS ARGUMENTS, pairs.count(), pairs.tokens(), pairs.values()); \
  }                                                                                           \
  RESULT NAME##V(__VA_ARGS__, RtInt n, RtToken tokens[], RtPointer values[])
#define KINORA_RI(NAME, LAST, ARGUMENTS, ...) KINORA_RI_OF(RtVoid, NAME, LAST, ARGUMENTS, __VA_ARGS__)
