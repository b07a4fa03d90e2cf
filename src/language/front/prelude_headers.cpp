// Headers that shaders of other systems expect beside stdosl.h: pairs and quadruples of numbers with their operators.
#include <string>

#include "language/front/prelude.h"

namespace kinora::language::front {

namespace {

// T(a) op by fields for a struct of two fields.
#define KN_PAIR(S, A, B, TA, TB)                                                                                    \
  "struct " S " { " TA " " A "; " TB " " B "; };\n" KN_PAIR_OP(S, A, B, "add", "+") KN_PAIR_OP(S, A, B, "sub", "-") \
      KN_PAIR_OP(S, A, B, "mul", "*") KN_PAIR_OP(S, A, B, "div", "/") S                                             \
      " __operator__neg__(" S " a) { return " S "(-a." A ", -a." B                                                  \
      "); }\n"                                                                                                      \
      "int __operator__eq__(" S " a, " S " b) { return a." A " == b." A " && a." B " == b." B                       \
      "; }\n"                                                                                                       \
      "int __operator__ne__(" S " a, " S " b) { return a." A " != b." A " || a." B " != b." B                       \
      "; }\n" KN_PAIR_F1(S, A, B, "abs") KN_PAIR_F1(S, A, B, "ceil") KN_PAIR_F1(S, A, B, "floor")                   \
          KN_PAIR_F1(S, A, B, "sqrt") KN_PAIR_F1(S, A, B, "exp") KN_PAIR_F1(S, A, B, "log")                         \
              KN_PAIR_F2(S, A, B, "max") KN_PAIR_F2(S, A, B, "min") KN_PAIR_F2(S, A, B, "pow")                      \
                  KN_PAIR_F2(S, A, B, "mod") KN_PAIR_F2(S, A, B, "fmod") S                                          \
      " mix(" S " a, " S " b, float x) { return " S "(mix(a." A ", b." A ", x), mix(a." B ", b." B ", x)); }\n" S   \
      " mix(" S " a, " S " b, " S " x) { return " S "(mix(a." A ", b." A ", x." A "), mix(a." B ", b." B ", x." B   \
      ")); }\n" S " clamp(" S " x, " S " lo, " S " hi) { return " S "(clamp(x." A ", lo." A ", hi." A               \
      "), clamp(x." B ", lo." B ", hi." B ")); }\n" S " clamp(" S " x, float lo, float hi) { return clamp(x, " S    \
      "(lo, lo), " S "(hi, hi)); }\n"
#define KN_PAIR_OP(S, A, B, NAME, OP)                                                                                \
  S " __operator__" NAME "__(" S " a, " S " b) { return " S "(a." A " " OP " b." A ", a." B " " OP " b." B           \
    "); }\n" S " __operator__" NAME "__(" S " a, float b) { return " S "(a." A " " OP " b, a." B " " OP " b); }\n" S \
    " __operator__" NAME "__(float a, " S " b) { return " S "(a " OP " b." A ", a " OP " b." B "); }\n"
#define KN_PAIR_F1(S, A, B, NAME) S " " NAME "(" S " a) { return " S "(" NAME "(a." A "), " NAME "(a." B ")); }\n"
#define KN_PAIR_F2(S, A, B, NAME)                                                                               \
  S " " NAME "(" S " a, " S " b) { return " S "(" NAME "(a." A ", b." A "), " NAME "(a." B ", b." B ")); }\n" S \
    " " NAME "(" S " a, float b) { return " S "(" NAME "(a." A ", b), " NAME "(a." B ", b)); }\n"

constexpr char kVector2[] = KN_PAIR("vector2", "x", "y", "float", "float")
    "float dot(vector2 a, vector2 b) { return a.x * b.x + a.y * b.y; }\n"
    "float length(vector2 a) { return sqrt(dot(a, a)); }\n"
    "float distance(vector2 a, vector2 b) { return length(a - b); }\n"
    "vector2 normalize(vector2 a) { float l = length(a); return l > 0.0 ? a / l : vector2(0.0, 0.0); }\n";
constexpr char kColor2[] = KN_PAIR("color2", "r", "a", "float", "float");
constexpr char kColor4[] = KN_PAIR("color4", "rgb", "a", "color", "float");

#define KN_FOUR_OP(NAME, OP)                                                                                      \
  "vector4 __operator__" NAME "__(vector4 a, vector4 b) { return vector4(a.x " OP " b.x, a.y " OP " b.y, a.z " OP \
  " b.z, a.w " OP                                                                                                 \
  " b.w); }\n"                                                                                                    \
  "vector4 __operator__" NAME "__(vector4 a, float b) { return vector4(a.x " OP " b, a.y " OP " b, a.z " OP       \
  " b, a.w " OP                                                                                                   \
  " b); }\n"                                                                                                      \
  "vector4 __operator__" NAME "__(float a, vector4 b) { return vector4(a " OP " b.x, a " OP " b.y, a " OP         \
  " b.z, a " OP " b.w); }\n"
#define KN_FOUR_F1(NAME) \
  "vector4 " NAME "(vector4 a) { return vector4(" NAME "(a.x), " NAME "(a.y), " NAME "(a.z), " NAME "(a.w)); }\n"
#define KN_FOUR_F2(NAME)                                                                                  \
  "vector4 " NAME "(vector4 a, vector4 b) { return vector4(" NAME "(a.x, b.x), " NAME "(a.y, b.y), " NAME \
  "(a.z, b.z), " NAME                                                                                     \
  "(a.w, b.w)); }\n"                                                                                      \
  "vector4 " NAME "(vector4 a, float b) { return vector4(" NAME "(a.x, b), " NAME "(a.y, b), " NAME       \
  "(a.z, b), " NAME "(a.w, b)); }\n"
constexpr char kVector4[] = "struct vector4 { float x; float y; float z; float w; };\n"
    KN_FOUR_OP("add", "+") KN_FOUR_OP("sub", "-") KN_FOUR_OP("mul", "*") KN_FOUR_OP("div", "/")
    "vector4 __operator__neg__(vector4 a) { return vector4(-a.x, -a.y, -a.z, -a.w); }\n"
    "int __operator__eq__(vector4 a, vector4 b) { return a.x == b.x && a.y == b.y && a.z == b.z && a.w == b.w; }\n"
    "int __operator__ne__(vector4 a, vector4 b) { return a.x != b.x || a.y != b.y || a.z != b.z || a.w != b.w; }\n"
    KN_FOUR_F1("abs") KN_FOUR_F1("ceil") KN_FOUR_F1("floor") KN_FOUR_F1("sqrt") KN_FOUR_F1("exp") KN_FOUR_F1("log")
    KN_FOUR_F2("max") KN_FOUR_F2("min") KN_FOUR_F2("pow") KN_FOUR_F2("mod") KN_FOUR_F2("fmod")
    "vector4 mix(vector4 a, vector4 b, float x) { return a * (1.0 - x) + b * x; }\n"
    "vector4 mix(vector4 a, vector4 b, vector4 x) { return a * (1.0 - x) + b * x; }\n"
    "vector4 clamp(vector4 x, vector4 lo, vector4 hi) { return max(min(x, hi), lo); }\n"
    "vector4 clamp(vector4 x, float lo, float hi) { return max(min(x, hi), lo); }\n"
    "float dot(vector4 a, vector4 b) { return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w; }\n"
    "float length(vector4 a) { return sqrt(dot(a, a)); }\n"
    "float distance(vector4 a, vector4 b) { return length(a - b); }\n"
    "vector4 normalize(vector4 a) { float l = length(a); return l > 0.0 ? a / l : vector4(0.0, 0.0, 0.0, 0.0); }\n"
    "vector4 transform(matrix m, vector4 a) {\n"
    "  return vector4(a.x * m[0][0] + a.y * m[1][0] + a.z * m[2][0] + a.w * m[3][0],\n"
    "                 a.x * m[0][1] + a.y * m[1][1] + a.z * m[2][1] + a.w * m[3][1],\n"
    "                 a.x * m[0][2] + a.y * m[1][2] + a.z * m[2][2] + a.w * m[3][2],\n"
    "                 a.x * m[0][3] + a.y * m[1][3] + a.z * m[2][3] + a.w * m[3][3]);\n"
    "}\n";

}  // namespace

std::string_view preludeHeader(std::string_view name) {
  if (const size_t slash = name.rfind('/'); slash != std::string_view::npos) name.remove_prefix(slash + 1);
  if (name == "vector2.h") return kVector2;
  if (name == "vector4.h") return kVector4;
  if (name == "color2.h") return kColor2;
  if (name == "color4.h") return kColor4;
  if (name == "oslutil.h") return "\n";  // what shaders use of it is in the library
  return {};
}

}  // namespace kinora::language::front
