// The operations of the intermediate form, each listed once. Names are those of .oso files.
//
// KN_LANGUAGE_OPCODES(X) expands X(Enumerator, "name", "letters", flags):
//   letters   what is done to each argument: w result, r operand, W both; the last one followed by * repeats.
//   flags     Opcode... bits below, or 0.
// `if`, loops and `functioncall` carry blocks (program.h). Types of operands are checked by operandTypesOf().
#pragma once
#include <cstdint>
#include <string_view>

namespace kinora::language {

enum : uint32_t {
  kOpBlocks = 1,        // holds blocks of code
  kOpEffect = 2,        // does something besides its results: never removed, kept in order
  kOpTakesDerivs = 4,   // needs the derivatives of its operands even when its result has none (Dx, texture, area ...)
  kOpDropsDerivs = 8,   // its results' derivatives are zero
  kOpGlobalState = 16,  // the answer depends on the point's renderer state, not on operands alone: varying
  kOpTable = 32,        // operands may be a list of "token", value pairs at the end
  kOpOwn = 64,  // ours: other compilers inline a function of their header instead, so no .oso of theirs has it
};

#define KN_LANGUAGE_OPCODES(X)                                                                  \
  X(Nop, "nop", "", 0)                                                                          \
  X(End, "end", "", 0)                                                                          \
  X(If, "if", "r", kOpBlocks)                                                                   \
  X(For, "for", "r", kOpBlocks)                                                                 \
  X(While, "while", "r", kOpBlocks)                                                             \
  X(DoWhile, "dowhile", "r", kOpBlocks)                                                         \
  X(Call, "functioncall", "r", kOpBlocks)                                                       \
  X(Break, "break", "", kOpEffect)                                                              \
  X(Continue, "continue", "", kOpEffect)                                                        \
  X(Return, "return", "", kOpEffect)                                                            \
  X(Exit, "exit", "", kOpEffect)                                                                \
  X(UseParam, "useparam", "r*", kOpEffect)                                                      \
  X(Assign, "assign", "wr", 0)                                                                  \
  X(ArrayCopy, "arraycopy", "wr", 0)                                                            \
  X(ArrayRef, "aref", "wrr", 0)                                                                 \
  X(ArrayAssign, "aassign", "Wrr", 0)                                                           \
  X(ComponentRef, "compref", "wrr", 0)                                                          \
  X(ComponentAssign, "compassign", "Wrr", 0)                                                    \
  X(MatrixRef, "mxcompref", "wrrr", kOpDropsDerivs)                                             \
  X(MatrixAssign, "mxcompassign", "Wrrr", kOpDropsDerivs)                                       \
  X(ArrayLength, "arraylength", "wr", kOpDropsDerivs)                                           \
  X(Add, "add", "wrr", 0)                                                                       \
  X(Sub, "sub", "wrr", 0)                                                                       \
  X(Mul, "mul", "wrr", 0)                                                                       \
  X(Div, "div", "wrr", 0)                                                                       \
  X(Mod, "mod", "wrr", kOpDropsDerivs)                                                          \
  X(Neg, "neg", "wr", 0)                                                                        \
  X(BitAnd, "bitand", "wrr", kOpDropsDerivs)                                                    \
  X(BitOr, "bitor", "wrr", kOpDropsDerivs)                                                      \
  X(BitXor, "xor", "wrr", kOpDropsDerivs)                                                       \
  X(ShiftLeft, "shl", "wrr", kOpDropsDerivs)                                                    \
  X(ShiftRight, "shr", "wrr", kOpDropsDerivs)                                                   \
  X(Complement, "compl", "wr", kOpDropsDerivs)                                                  \
  X(And, "and", "wrr", kOpDropsDerivs)                                                          \
  X(Or, "or", "wrr", kOpDropsDerivs)                                                            \
  X(Eq, "eq", "wrr", kOpDropsDerivs)                                                            \
  X(Neq, "neq", "wrr", kOpDropsDerivs)                                                          \
  X(Lt, "lt", "wrr", kOpDropsDerivs)                                                            \
  X(Le, "le", "wrr", kOpDropsDerivs)                                                            \
  X(Gt, "gt", "wrr", kOpDropsDerivs)                                                            \
  X(Ge, "ge", "wrr", kOpDropsDerivs)                                                            \
  X(MakeColor, "color", "wr*", 0)                                                               \
  X(MakePoint, "point", "wr*", 0)                                                               \
  X(MakeVector, "vector", "wr*", 0)                                                             \
  X(MakeNormal, "normal", "wr*", 0)                                                             \
  X(MakeMatrix, "matrix", "wr*", kOpDropsDerivs)                                                \
  X(MakeClosure, "closure", "wr*", kOpEffect)                                                   \
  X(Cos, "cos", "wr", 0)                                                                        \
  X(Sin, "sin", "wr", 0)                                                                        \
  X(Tan, "tan", "wr", 0)                                                                        \
  X(SinCos, "sincos", "rww", 0)                                                                 \
  X(Acos, "acos", "wr", 0)                                                                      \
  X(Asin, "asin", "wr", 0)                                                                      \
  X(Atan, "atan", "wr", 0)                                                                      \
  X(Atan2, "atan2", "wrr", 0)                                                                   \
  X(Cosh, "cosh", "wr", 0)                                                                      \
  X(Sinh, "sinh", "wr", 0)                                                                      \
  X(Tanh, "tanh", "wr", 0)                                                                      \
  X(Radians, "radians", "wr", 0)                                                                \
  X(Degrees, "degrees", "wr", 0)                                                                \
  X(Pow, "pow", "wrr", 0)                                                                       \
  X(Exp, "exp", "wr", 0)                                                                        \
  X(Exp2, "exp2", "wr", 0)                                                                      \
  X(Expm1, "expm1", "wr", 0)                                                                    \
  X(Log, "log", "wrr*", 0)                                                                      \
  X(Log2, "log2", "wr", 0)                                                                      \
  X(Log10, "log10", "wr", 0)                                                                    \
  X(Logb, "logb", "wr", kOpDropsDerivs)                                                         \
  X(Sqrt, "sqrt", "wr", 0)                                                                      \
  X(InverseSqrt, "inversesqrt", "wr", 0)                                                        \
  X(Cbrt, "cbrt", "wr", 0)                                                                      \
  X(Abs, "abs", "wr", 0)                                                                        \
  X(Fabs, "fabs", "wr", 0)                                                                      \
  X(Sign, "sign", "wr", kOpDropsDerivs)                                                         \
  X(Floor, "floor", "wr", kOpDropsDerivs)                                                       \
  X(Ceil, "ceil", "wr", kOpDropsDerivs)                                                         \
  X(Round, "round", "wr", kOpDropsDerivs)                                                       \
  X(Trunc, "trunc", "wr", kOpDropsDerivs)                                                       \
  X(Fmod, "fmod", "wrr", 0)                                                                     \
  X(Step, "step", "wrr", kOpDropsDerivs)                                                        \
  X(Min, "min", "wrr", 0)                                                                       \
  X(Max, "max", "wrr", 0)                                                                       \
  X(Clamp, "clamp", "wrrr", 0)                                                                  \
  X(Mix, "mix", "wrrr", 0)                                                                      \
  X(Select, "select", "wrrr", 0)                                                                \
  X(SmoothStep, "smoothstep", "wrrr", 0)                                                        \
  X(IsNan, "isnan", "wr", kOpDropsDerivs)                                                       \
  X(IsInf, "isinf", "wr", kOpDropsDerivs)                                                       \
  X(IsFinite, "isfinite", "wr", kOpDropsDerivs)                                                 \
  X(Erf, "erf", "wr", 0)                                                                        \
  X(Erfc, "erfc", "wr", 0)                                                                      \
  X(Cross, "cross", "wrr", 0)                                                                   \
  X(Dot, "dot", "wrr", 0)                                                                       \
  X(Length, "length", "wr", 0)                                                                  \
  X(Distance, "distance", "wrr", 0)                                                             \
  X(Normalize, "normalize", "wr", 0)                                                            \
  X(Determinant, "determinant", "wr", kOpDropsDerivs)                                           \
  X(Transpose, "transpose", "wr", kOpDropsDerivs)                                               \
  X(GetMatrix, "getmatrix", "wrr*", kOpDropsDerivs | kOpGlobalState)                            \
  X(TransformPoint, "transform", "wrr*", kOpGlobalState)                                        \
  X(TransformVector, "transformv", "wrr*", kOpGlobalState)                                      \
  X(TransformNormal, "transformn", "wrr*", kOpGlobalState)                                      \
  X(TransformColor, "transformc", "wrr*", 0)                                                    \
  X(Luminance, "luminance", "wr", 0)                                                            \
  X(Blackbody, "blackbody", "wr", kOpDropsDerivs)                                               \
  X(WavelengthColor, "wavelength_color", "wr", kOpDropsDerivs)                                  \
  X(Noise, "noise", "wr*", kOpTakesDerivs | kOpTable)                                           \
  X(SNoise, "snoise", "wr*", 0)                                                                 \
  X(PNoise, "pnoise", "wr*", kOpTakesDerivs | kOpTable)                                         \
  X(PSNoise, "psnoise", "wr*", 0)                                                               \
  X(CellNoise, "cellnoise", "wr*", kOpDropsDerivs)                                              \
  X(HashNoise, "hashnoise", "wr*", kOpDropsDerivs)                                              \
  X(Hash, "hash", "wr*", kOpDropsDerivs)                                                        \
  X(Spline, "spline", "wr*", 0)                                                                 \
  X(SplineInverse, "splineinverse", "wr*", 0)                                                   \
  X(DerivX, "Dx", "wr", kOpTakesDerivs | kOpDropsDerivs)                                        \
  X(DerivY, "Dy", "wr", kOpTakesDerivs | kOpDropsDerivs)                                        \
  X(DerivZ, "Dz", "wr", kOpTakesDerivs | kOpDropsDerivs)                                        \
  X(FilterWidth, "filterwidth", "wr", kOpTakesDerivs | kOpDropsDerivs)                          \
  X(Area, "area", "wr", kOpTakesDerivs | kOpDropsDerivs)                                        \
  X(CalculateNormal, "calculatenormal", "wr", kOpTakesDerivs | kOpDropsDerivs | kOpGlobalState) \
  X(Printf, "printf", "r*", kOpEffect)                                                          \
  X(Error, "error", "r*", kOpEffect)                                                            \
  X(Warning, "warning", "r*", kOpEffect)                                                        \
  X(Fprintf, "fprintf", "r*", kOpEffect)                                                        \
  X(Format, "format", "wr*", kOpDropsDerivs)                                                    \
  X(Concat, "concat", "wr*", kOpDropsDerivs)                                                    \
  X(Strlen, "strlen", "wr", kOpDropsDerivs)                                                     \
  X(GetChar, "getchar", "wrr", kOpDropsDerivs)                                                  \
  X(StartsWith, "startswith", "wrr", kOpDropsDerivs)                                            \
  X(EndsWith, "endswith", "wrr", kOpDropsDerivs)                                                \
  X(Substr, "substr", "wrrr", kOpDropsDerivs)                                                   \
  X(StoI, "stoi", "wr", kOpDropsDerivs)                                                         \
  X(StoF, "stof", "wr", kOpDropsDerivs)                                                         \
  X(Split, "split", "wrWr*", kOpDropsDerivs)                                                    \
  X(RegexSearch, "regex_search", "wr*", kOpDropsDerivs)                                         \
  X(RegexMatch, "regex_match", "wr*", kOpDropsDerivs)                                           \
  X(Texture, "texture", "wr*", kOpTakesDerivs | kOpTable)                                       \
  X(Texture3d, "texture3d", "wr*", kOpTakesDerivs | kOpTable)                                   \
  X(Environment, "environment", "wr*", kOpTakesDerivs | kOpTable)                               \
  X(GetTextureInfo, "gettextureinfo", "wr*", kOpDropsDerivs)                                    \
  X(GetAttribute, "getattribute", "wr*", kOpGlobalState)                                        \
  X(SetMessage, "setmessage", "rr", kOpEffect)                                                  \
  X(GetMessage, "getmessage", "wr*", kOpEffect | kOpDropsDerivs)                                \
  X(SurfaceArea, "surfacearea", "w", kOpDropsDerivs | kOpGlobalState)                           \
  X(Backfacing, "backfacing", "w", kOpDropsDerivs | kOpGlobalState)                             \
  X(RayType, "raytype", "wr", kOpDropsDerivs | kOpGlobalState)                                  \
  X(IsConnected, "isconnected", "wr", kOpDropsDerivs)                                           \
  X(IsConstant, "isconstant", "wr", kOpDropsDerivs)                                             \
  X(DictFind, "dict_find", "wrr", kOpDropsDerivs)                                               \
  X(DictNext, "dict_next", "wr", kOpDropsDerivs)                                                \
  X(DictValue, "dict_value", "wrrW", kOpDropsDerivs)                                            \
  X(Trace, "trace", "wrr*", kOpEffect | kOpDropsDerivs | kOpTable)                              \
  X(PointCloudSearch, "pointcloud_search", "wr*", kOpEffect | kOpDropsDerivs)                   \
  X(PointCloudGet, "pointcloud_get", "wr*", kOpEffect | kOpDropsDerivs)                         \
  X(PointCloudWrite, "pointcloud_write", "wr*", kOpEffect | kOpDropsDerivs)                     \
  X(FloorMod, "floormod", "wrr", kOpOwn)                                                        \
  X(LinearStep, "linearstep", "wrrr", kOpOwn)                                                   \
  X(SmoothLinearStep, "smooth_linearstep", "wrrrr", kOpOwn)                                     \
  X(FaceForward, "faceforward", "wrrr", kOpOwn)                                                 \
  X(Reflect, "reflect", "wrr", kOpOwn)                                                          \
  X(Refract, "refract", "wrrr", kOpOwn)                                                         \
  X(Rotate, "rotate", "wrrr", kOpOwn)                                                           \
  X(DebugNan, "debug_nan", "rrr*", kOpEffect | kOpOwn)                                          \
  X(DebugUninit, "debug_uninit", "rrWr*", kOpEffect | kOpOwn)                                   \
  X(CheckIndex, "check_index", "rr", kOpEffect | kOpOwn)                                        \
  X(Complain, "complain", "r*", kOpEffect | kOpOwn)                                             \
  X(ClosureMake, "closure_make", "wrr*", kOpDropsDerivs | kOpGlobalState | kOpOwn)              \
  X(ClosureAdd, "closure_add", "wrr", kOpDropsDerivs | kOpGlobalState | kOpOwn)                 \
  X(ClosureMul, "closure_mul", "wrr", kOpDropsDerivs | kOpGlobalState | kOpOwn)                 \
  X(ClosureText, "closure_text", "wr", kOpDropsDerivs | kOpGlobalState | kOpOwn)
// FloorMod is the function mod(): a - b * floor(a / b) for floats and triples (a where b is 0; derivatives a' - b' *
// floor(a / b)), a % b for ints (a where b is 0). Mod is the operator %. LinearStep and SmoothLinearStep: e0, e1, x
// (, eps), float or triples alike. Rotate: the triple, the angle, the axis, which passes through the origin and need
// not have length 1. Formulas: reference osl-numerics, section 8. DebugNan and DebugUninit (instrument.h): two texts,
// the value, and which element, component or row and column of it. CheckIndex: an index and how many
// elements there are: what is left of a store that nothing reads. Complain: an error of the program itself, told once a
// run. ClosureMake and its kin work on closures as numbers (optimise/closure_values.cpp). No file may hold these eight.

enum class Opcode : uint8_t {
#define KN_X(enumerator, name, letters, flags) enumerator,
  KN_LANGUAGE_OPCODES(KN_X)
#undef KN_X
      Count
};

constexpr bool isLoop(Opcode op) { return op == Opcode::For || op == Opcode::While || op == Opcode::DoWhile; }

struct OpcodeFacts {
  std::string_view name, letters;
  uint32_t flags;
  uint32_t fixed =
      repeats() ? uint32_t(letters.size()) - 2 : uint32_t(letters.size());  // arguments before those that repeat
  char further = repeats() ? letters[letters.size() - 2] : 'r';
  constexpr bool repeats() const { return !letters.empty() && letters.back() == '*'; }
};
const OpcodeFacts& factsOf(Opcode);
Opcode opcodeNamed(std::string_view name);  // Opcode::Count when there is none
// 'r', 'w' or 'W' for argument i of an instruction of `count` arguments; an opcode whose letters end in * repeats the
// letter before it. A destination that stands last (getattribute ...) is known by its place. Optional outputs behind
// a token ("alpha", "errormessage" of texture) are not: whoever asks for them has the constants at hand (program.h).
char accessOf(Opcode, uint32_t i, uint32_t count);

}  // namespace kinora::language
