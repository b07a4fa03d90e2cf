// What one instruction of the group machine is: a kernel over a block of points, and the words that say where its
// operands lie. Kernels come in families, one file each; the lists here give them their numbers. Plain header.
//
// A value lives in cells: a varying component is an array of one float (or int, or string handle) for each point of
// the block, a uniform one is a single number. `Frame::cells` points to all of them; components follow each other.
// Words of an elementwise kernel: number of components, then result and operands:
//   plain    result {cell}           operand {cell, step}                       step 0: a scalar for all components
//   dual     result {cell, dx, dy}   operand {cell, step, dx, dy, derivStep}    the zero cell stands for no
//   derivatives
#pragma once
#include <cstddef>
#include <cstdint>

namespace kinora::language {

class RunState;

struct Frame {
  float* const* cells;
  uint32_t points;  // of the block; 1 for uniform instructions
  uint32_t first;   // the block's first point within the run
  uint32_t chunks;  // bit k: some of the 16 points from 16 k on take part; nobody reads what is computed for others
  RunState* run;
};

// The next run of chunks that take part, as points; false when there is none.
inline bool nextRun(uint32_t& chunks, uint32_t points, uint32_t& first, uint32_t& end) {
  if (!chunks) return false;
  const uint32_t start = uint32_t(__builtin_ctz(chunks)),
                 length = uint32_t(__builtin_ctzll(~(uint64_t(chunks) >> start)));
  first = start * 16;
  end = (start + length) * 16 < points ? (start + length) * 16 : points;
  chunks &= uint32_t(~(((uint64_t(1) << length) - 1) << start));
  return true;
}
// Points i of the chunks that take part, W at a time: run by run, so that a whole block is one plain loop.
#define KN_EACH(f, i, W)                                                          \
  for (uint32_t chunks_ = (f).chunks, points_ = (f).points, first_ = 0, end_ = 0; \
       nextRun(chunks_, points_, first_, end_);)                                  \
    for (uint32_t i = first_; i < end_; i += (W))

using KernelFunction = void (*)(const Frame&, const uint32_t* words);

// Cheap operations of two numbers: each of the operands may be uniform (U) or varying (V).
#define KN_VM_BINARY(X) X(Add) X(Sub) X(Mul) X(Div) X(DivPlain) X(Min) X(Max)
// One number in, one out, with a dual form.
#define KN_VM_UNARY(X)                                                                                        \
  X(Neg)                                                                                                      \
  X(Abs)                                                                                                      \
  X(Sin) X(Cos) X(Tan) X(Asin) X(Acos) X(Atan) X(Sinh) X(Cosh) X(Tanh) X(Exp) X(Exp2) X(Expm1) X(Log) X(Log2) \
      X(Log10) X(Sqrt) X(InverseSqrt) X(Cbrt) X(Erf) X(Erfc) X(Radians) X(Degrees)
// No derivatives.
#define KN_VM_ROUNDING(X) X(Floor) X(Ceil) X(Round) X(Trunc) X(Sign) X(Logb)
// Two to four numbers, any of them uniform, with a dual form. Words: as above, each operand followed by a flag that
// is 1 when it varies.
#define KN_VM_MIXED2(X) X(Pow) X(Atan2) X(Fmod) X(FloorMod) X(Step)
#define KN_VM_MIXED3(X) X(Clamp) X(Mix) X(Select) X(SelectI) X(SmoothStep) X(LinearStep)
#define KN_VM_MIXED4(X) X(SmoothLinearStep)
// Comparisons of numbers, result int; of triples the components' answers are joined (and for Eq, or for Neq).
#define KN_VM_COMPARE(X) X(EqF) X(NeqF) X(LtF) X(LeF) X(GtF) X(GeF) X(EqI) X(NeqI) X(LtI) X(LeI) X(GtI) X(GeI)
#define KN_VM_INT(X) \
  X(AddI)            \
  X(SubI)            \
  X(MulI) X(DivI) X(ModI) X(FloorModI) X(AndBits) X(OrBits) X(XorBits) X(Shl) X(Shr) X(MinI) X(MaxI) X(AndI) X(OrI)
#define KN_VM_INT1(X) X(NegI) X(AbsI) X(Complement) X(ToFloat) X(ToInt) X(IsNan) X(IsInf) X(IsFinite) X(NotZeroF)
#define KN_VM_MEMORY(X) \
  X(Copy)               \
  X(Broadcast) X(Fill) X(Blend) X(BlendUniform) X(MaskAll) X(MaskSplit) X(MaskAnd) X(MaskCopy) X(MaskClear) X(MaskAny)
// What a choice, the narrowing of a mask or its splitting may depend on (fused.cpp).
#define KN_VM_CONDITION(X) X(LtF) X(LeF) X(LtI) X(LeI) X(EqF) X(NeqF) X(EqI) X(NeqI)
// Triples. Operands as in KN_VM_MIXED2.
#define KN_VM_VECTOR(X)                                                                               \
  X(Dot)                                                                                              \
  X(Cross)                                                                                            \
  X(Length) X(Distance) X(Normalize) X(Reflect) X(Refract) X(FaceForward) X(Rotate) X(TransformPoint) \
      X(TransformVector) X(TransformNormal) X(SegmentDistance)  // a normal by the inverse matrix
#define KN_VM_MATRIX(X) X(MatrixMul) X(MatrixTranspose) X(MatrixDeterminant) X(MatrixInverse)
#define KN_VM_DERIV(X) X(FilterWidth) X(AreaOf) X(NormalOf)
// Noises of N coordinates (1 to 4) and 1 or 3 results. Words: unsigned, periodic, result, N coordinates and, where
// periodic, N periods; operands as in KN_VM_MIXED2, periods plain. HashN: result (int), then N plain operands.
#define KN_VM_DIMENSIONS(X, name) \
  X(name##1) X(name##1x3) X(name##2) X(name##2x3) X(name##3) X(name##3x3) X(name##4) X(name##4x3)
// Gabor: periodic, result (dual), 3 coordinates (dual), 3 periods, then the options {anisotropic cell}, {filter
// cell}, direction, bandwidth, impulses.
#define KN_VM_HASH(X) X(HashWords1) X(HashWords2) X(HashWords3) X(HashWords4)
// Colour. TransformColor: from and to (ColorSpace), then result and operand; the others are functions of one operand.
#define KN_VM_COLOR(X) X(Luminance) X(TransformColor)
#define KN_VM_SPECTRUM(X) X(Blackbody) X(WavelengthColor)
// Splines of 1 or 3 components over uniform (U) or varying (V) knots, dual in x (D) and in the knots (DD). Words:
// basis, number of knots, knots, their dx, their dy, result, x as in KN_VM_MIXED2.
#define KN_VM_SPLINE(X)                                                                                             \
  X(Spline1U)                                                                                                       \
  X(Spline1V)                                                                                                       \
  X(Spline1DU) X(Spline1DV) X(Spline1DD) X(Spline3U) X(Spline3V) X(Spline3DU) X(Spline3DV) X(Spline3DD) X(InverseU) \
      X(InverseV) X(InverseDU) X(InverseDV)
// One function for all widths: work on one point after the other.
#define KN_VM_SCALAR(X)                                                                                             \
  X(ArrayRead)                                                                                                      \
  X(ArrayWrite)                                                                                                     \
  X(CheckIndex) X(LoopLimit) X(Refuse) X(Printf) X(Format) X(Concat) X(Strlen) X(GetChar) X(StartsWith) X(EndsWith) \
      X(Substr) X(StoI) X(StoF) X(Split) X(Regex) X(HashString) X(GetMatrix) X(GetAttribute) X(RayType)             \
          X(Backfacing) X(SurfaceArea) X(Texture) X(GetTextureInfo) X(Trace) X(GetMessage) X(DictFind) X(DictNext)  \
              X(DictValue) X(DebugNan) X(DebugUninit) X(ClosureMake) X(ClosureAdd) X(ClosureMul) X(ClosureText)

enum class Family : uint8_t {
  Arithmetic,
  Math,
  Mixed,
  Integer,
  Memory,
  Vector,
  Noise,
  Color,
  Spline,
  Fused,
  Scalar,
  Count
};

// Numbers within a family.
#define KN_VM_ONE(name) name,
#define KN_VM_DUAL(name) name, name##D,
#define KN_VM_SIX(name) name, name##UV, name##VU, name##D, name##DUV, name##DVU,
enum class Arithmetic : uint16_t { KN_VM_BINARY(KN_VM_SIX) Count };
enum class Math : uint16_t { KN_VM_UNARY(KN_VM_DUAL) KN_VM_ROUNDING(KN_VM_ONE) Count };
enum class Mixed : uint16_t {
  KN_VM_MIXED2(KN_VM_DUAL) KN_VM_MIXED3(KN_VM_DUAL) KN_VM_MIXED4(KN_VM_DUAL) KN_VM_COMPARE(KN_VM_ONE) Count
};
enum class Integer : uint16_t { KN_VM_INT(KN_VM_ONE) KN_VM_INT1(KN_VM_ONE) Count };
enum class Memory : uint16_t { KN_VM_MEMORY(KN_VM_ONE) Count };
// Two operations at once: the first with its operands' kinds, the second, in which SubFrom takes the first's result
// from its other operand.
enum class PairFirst : uint16_t { Add, AddVU, Mul, MulVU, Sub, SubUV, SubVU, Count };
enum class PairSecond : uint16_t { Add, Sub, SubFrom, Mul, Div, Count };
enum class Condition : uint16_t { KN_VM_CONDITION(KN_VM_ONE) Count };
inline constexpr int kOrders = 4;  // the first conditions, of which two may stand in one kernel
// ((first * seconds + second) * 2 + uniform) * 2 + masked; then Arithmetic's plain kernels under a mask, three for
// each; then a choice, a mask's narrowing and its splitting, by condition; then two choices or narrowings at once.
enum class Fused : uint16_t {
  Pair = 0,
  Masked = uint16_t(PairFirst::Count) * uint16_t(PairSecond::Count) * 4,
  Choose = Masked + uint16_t(Arithmetic::Count) / 2,
  Narrow = Choose + uint16_t(Condition::Count),
  Split = Narrow + uint16_t(Condition::Count),
  ChooseTwice = Split + uint16_t(Condition::Count),  // outer condition * kOrders + inner
  NarrowTwice = ChooseTwice + kOrders * kOrders,
  Count = NarrowTwice + kOrders * kOrders
};
enum class Scalar : uint16_t { KN_VM_SCALAR(KN_VM_ONE) Count };
enum class Vector : uint16_t { KN_VM_VECTOR(KN_VM_DUAL) KN_VM_MATRIX(KN_VM_ONE) KN_VM_DERIV(KN_VM_ONE) Count };

enum class Spectral : uint16_t { KN_VM_COLOR(KN_VM_DUAL) KN_VM_SPECTRUM(KN_VM_ONE) Count };
enum class Splines : uint16_t { KN_VM_SPLINE(KN_VM_ONE) Count };
enum class Noise : uint16_t {
  KN_VM_DIMENSIONS(KN_VM_DUAL, Perlin) KN_VM_DIMENSIONS(KN_VM_DUAL, Simplex) KN_VM_DIMENSIONS(KN_VM_ONE, Cell)
      KN_VM_DIMENSIONS(KN_VM_ONE, Hash) KN_VM_HASH(KN_VM_ONE) Gabor,
  Gaborx3,
  Count
};

// The functions of a family for a width of 1, 4, 8 or 16, in the order of its enumeration; null for another width.
const KernelFunction* arithmeticKernels(uint32_t width);
const KernelFunction* mathKernels(uint32_t width);
const KernelFunction* mixedKernels(uint32_t width);
const KernelFunction* integerKernels(uint32_t width);
const KernelFunction* memoryKernels(uint32_t width);
const KernelFunction* vectorKernels(uint32_t width);
const KernelFunction* noiseKernels(uint32_t width);
const KernelFunction* colorKernels(uint32_t width);
const KernelFunction* splineKernels(uint32_t width);
const KernelFunction* fusedKernels(uint32_t width);
const KernelFunction* scalarKernels();

struct KernelName {
  Family family;
  uint16_t number;
  KernelName(Arithmetic k) : family(Family::Arithmetic), number(uint16_t(k)) {}
  KernelName(Math k) : family(Family::Math), number(uint16_t(k)) {}
  KernelName(Mixed k) : family(Family::Mixed), number(uint16_t(k)) {}
  KernelName(Integer k) : family(Family::Integer), number(uint16_t(k)) {}
  KernelName(Memory k) : family(Family::Memory), number(uint16_t(k)) {}
  KernelName(Noise k) : family(Family::Noise), number(uint16_t(k)) {}
  KernelName(Spectral k) : family(Family::Color), number(uint16_t(k)) {}
  KernelName(Splines k) : family(Family::Spline), number(uint16_t(k)) {}
  KernelName(Fused k) : family(Family::Fused), number(uint16_t(k)) {}
  KernelName(Scalar k) : family(Family::Scalar), number(uint16_t(k)) {}
  KernelName(Vector k) : family(Family::Vector), number(uint16_t(k)) {}
};

const char* nameOfKernel(KernelName);

}  // namespace kinora::language
