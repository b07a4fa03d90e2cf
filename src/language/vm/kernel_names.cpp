// Kernels' names, for listings.
#include "language/vm/kernel.h"

namespace kinora::language {

namespace {
#undef KN_VM_ONE
#undef KN_VM_DUAL
#undef KN_VM_SIX
#define KN_VM_ONE(name) #name,
#define KN_VM_DUAL(name) #name, #name "'",
#define KN_VM_SIX(name) #name, #name " uv", #name " vu", #name "'", #name "' uv", #name "' vu",
const char* const kArithmetic[] = {KN_VM_BINARY(KN_VM_SIX)};
const char* const kMath[] = {KN_VM_UNARY(KN_VM_DUAL) KN_VM_ROUNDING(KN_VM_ONE)};
const char* const kMixed[] = {KN_VM_MIXED2(KN_VM_DUAL) KN_VM_MIXED3(KN_VM_DUAL) KN_VM_MIXED4(KN_VM_DUAL)
                                  KN_VM_COMPARE(KN_VM_ONE)};
const char* const kInteger[] = {KN_VM_INT(KN_VM_ONE) KN_VM_INT1(KN_VM_ONE)};
const char* const kMemory[] = {KN_VM_MEMORY(KN_VM_ONE)};
const char* const kVector[] = {KN_VM_VECTOR(KN_VM_DUAL) KN_VM_MATRIX(KN_VM_ONE) KN_VM_DERIV(KN_VM_ONE)};
const char* const kScalarNames[] = {KN_VM_SCALAR(KN_VM_ONE)};
const char* const kColor[] = {KN_VM_COLOR(KN_VM_DUAL) KN_VM_SPECTRUM(KN_VM_ONE)};
const char* const kSpline[] = {KN_VM_SPLINE(KN_VM_ONE)};
const char* const kNoise[] = {KN_VM_DIMENSIONS(KN_VM_DUAL, Perlin) KN_VM_DIMENSIONS(KN_VM_DUAL, Simplex)
                                  KN_VM_DIMENSIONS(KN_VM_ONE, Cell) KN_VM_DIMENSIONS(KN_VM_ONE, Hash)
                                      KN_VM_HASH(KN_VM_ONE) "Gabor",
                              "Gaborx3"};
#define KN_SECOND(first, second) \
  first " " second, first " " second " if", first " " second " u", first " " second " u if",
#define KN_FIRST(first)   \
  KN_SECOND(first, "Add") \
  KN_SECOND(first, "Sub") KN_SECOND(first, "SubFrom") KN_SECOND(first, "Mul") KN_SECOND(first, "Div")
const char* const kFusedNames[] = {KN_FIRST("Add") KN_FIRST("Add vu") KN_FIRST("Mul") KN_FIRST("Mul vu")
                                       KN_FIRST("Sub") KN_FIRST("Sub uv") KN_FIRST("Sub vu")
#define KN_X(name) #name " if", #name " uv if", #name " vu if",
                                           KN_VM_BINARY(KN_X)
#undef KN_X
#define KN_X(name) "Choose " #name,
                                               KN_VM_CONDITION(KN_X)
#undef KN_X
#define KN_X(name) "MaskAnd " #name,
                                                   KN_VM_CONDITION(KN_X)
#undef KN_X
#define KN_X(name) "MaskSplit " #name,
                                                       KN_VM_CONDITION(KN_X)
#undef KN_X
#define KN_TWO(what, first) \
  what " " first " LtF", what " " first " LeF", what " " first " LtI", what " " first " LeI",
#define KN_FOUR(what) KN_TWO(what, "LtF") KN_TWO(what, "LeF") KN_TWO(what, "LtI") KN_TWO(what, "LeI")
                                                           KN_FOUR("Choose") KN_FOUR("MaskAnd")};
static_assert(sizeof kFusedNames / sizeof *kFusedNames == size_t(Fused::Count));
}  // namespace

const char* nameOfKernel(KernelName k) {
  switch (k.family) {
    case Family::Arithmetic:
      return kArithmetic[k.number];
    case Family::Math:
      return kMath[k.number];
    case Family::Mixed:
      return kMixed[k.number];
    case Family::Integer:
      return kInteger[k.number];
    case Family::Memory:
      return kMemory[k.number];
    case Family::Vector:
      return kVector[k.number];
    case Family::Noise:
      return kNoise[k.number];
    case Family::Color:
      return kColor[k.number];
    case Family::Spline:
      return kSpline[k.number];
    case Family::Fused:
      return kFusedNames[k.number];
    default:
      return kScalarNames[k.number];
  }
}

}  // namespace kinora::language
