// Headers that shaders of other systems expect beside stdosl.h: pairs and quadruples of numbers with their operators,
// matrices of three rows, lines along edges. What each declares is the interface that shaders know; the text is made
// here, field by field.
#include <string>
#include <utility>
#include <vector>

#include "language/front/prelude.h"

namespace kinora::language::front {

namespace {

// A struct whose operators and functions work on each field for itself.
struct Shape {
  std::string name;
  std::vector<std::pair<std::string, std::string>> fields;  // type, name
};

// S(f(a.x, b.x), f(a.y, b.y) ...): `each` with $ in place of a field's name.
std::string ofFields(const Shape& s, const std::string& each, const char* between = ", ") {
  std::string text;
  for (const auto& [type, field] : s.fields) {
    if (!text.empty()) text += between;
    for (const char c : each) text += c == '$' ? field : std::string(1, c);
  }
  return text;
}

std::string shapeHeader(const Shape& s) {
  const std::string& S = s.name;
  std::string guard = S;
  for (char& c : guard) c = c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c;
  std::string all = "#define " + guard + "_H\nstruct " + S + " { ";
  for (const auto& [type, field] : s.fields) all += type + " " + field + "; ";
  all += "};\n";
  const auto function = [&](const std::string& name, const std::string& parameters, const std::string& each) {
    all += S + " " + name + "(" + parameters + ") { return " + S + "(" + ofFields(s, each) + "); }\n";
  };
  for (const auto& [name, op] : {std::pair{"add", "+"}, {"sub", "-"}, {"mul", "*"}, {"div", "/"}}) {
    const std::string n = "__operator__" + std::string(name) + "__", o = " " + std::string(op) + " ";
    function(n, S + " a, " + S + " b", "a.$" + o + "b.$");
    function(n, S + " a, float b", "a.$" + o + "b");
    function(n, "float a, " + S + " b", "a" + o + "b.$");
    // not as ints: 1 / 2 is a half here
    function(n, S + " a, int b", "a.$" + o + "(float)b");
    function(n, "int a, " + S + " b", "(float)a" + o + "b.$");
  }
  function("__operator__neg__", S + " a", "-a.$");
  all += "int __operator__eq__(" + S + " a, " + S + " b) { return " + ofFields(s, "a.$ == b.$", " && ") + "; }\n";
  all += "int __operator__ne__(" + S + " a, " + S + " b) { return " + ofFields(s, "a.$ != b.$", " || ") + "; }\n";
  for (const char* f : {"abs", "ceil", "floor", "sqrt", "exp", "log", "log2", "sign", "sin", "cos", "tan", "asin",
                        "acos", "round", "trunc"})
    function(f, S + " a", std::string(f) + "(a.$)");
  for (const char* f : {"max", "min", "pow", "mod", "fmod", "atan2"}) {
    function(f, S + " a, " + S + " b", std::string(f) + "(a.$, b.$)");
    function(f, S + " a, float b", std::string(f) + "(a.$, b)");
  }
  function("fmod", S + " a, int b", "fmod(a.$, (float)b)");
  function("mix", S + " a, " + S + " b, float x", "mix(a.$, b.$, x)");
  function("mix", S + " a, " + S + " b, " + S + " x", "mix(a.$, b.$, x.$)");
  for (const char* f : {"smoothstep", "clamp"}) {  // whose value stands last, or first
    const bool isFirst = f[0] == 'c';
    const std::string name = f, each = isFirst ? "(x.$, a.$, b.$)" : "(a.$, b.$, x.$)",
                      whole = isFirst ? "(x.$, a, b)" : "(a, b, x.$)";
    const auto order = [&](const std::string& edge) {
      return isFirst ? S + " x, " + edge + " a, " + edge + " b" : edge + " a, " + edge + " b, " + S + " x";
    };
    function(name, order(S), name + each);
    function(name, order("float"), name + whole);
  }
  return all;
}

// Of shapes whose fields are floats: coordinates.
std::string vectorHeader(const Shape& s) {
  const std::string& S = s.name;
  return shapeHeader(s) + "float dot(" + S + " a, " + S + " b) { return " + ofFields(s, "a.$ * b.$", " + ") +
         "; }\nfloat length(" + S + " a) { return sqrt(dot(a, a)); }\nfloat distance(" + S + " a, " + S +
         " b) { return length(a - b); }\n" + S + " normalize(" + S +
         " a) { float l = length(a); return l > 0.0 ? a / l : a * 0.0; }\n";
}

std::string vector4Header() {
  return vectorHeader({"vector4", {{"float", "x"}, {"float", "y"}, {"float", "z"}, {"float", "w"}}}) + R"(
vector vec4ToVec3(vector4 v) { return vector(v.x, v.y, v.z) / v.w; }
vector4 transform(matrix m, vector4 a) {
  return vector4(a.x * m[0][0] + a.y * m[1][0] + a.z * m[2][0] + a.w * m[3][0],
                 a.x * m[0][1] + a.y * m[1][1] + a.z * m[2][1] + a.w * m[3][1],
                 a.x * m[0][2] + a.y * m[1][2] + a.z * m[2][2] + a.w * m[3][2],
                 a.x * m[0][3] + a.y * m[1][3] + a.z * m[2][3] + a.w * m[3][3]);
}
vector4 transform(string from, string to, vector4 a) { return transform(matrix(from, to), a); }
)";
}

std::string color4Header() {
  return shapeHeader({"color4", {{"color", "rgb"}, {"float", "a"}}}) + R"(
float dot(color4 a, color b) { return dot(a.rgb, b); }
color4 transformc(string to, color4 c) { return color4(transformc(to, c.rgb), c.a); }
color4 transformc(string from, string to, color4 c) { return color4(transformc(from, to, c.rgb), c.a); }
)";
}

// Rows and columns of three in the corner of a matrix, which multiplies and inverts as they would.
constexpr char kMatrix33[] = R"(#define MATRIX33_H
struct matrix33 { matrix m; };
int isValidAs33(matrix m) {
  return m[0][3] == 0 && m[1][3] == 0 && m[2][3] == 0 && m[3][0] == 0 && m[3][1] == 0 && m[3][2] == 0 && m[3][3] == 1;
}
matrix matrix33To44(matrix33 a) { return a.m; }
matrix33 matrix44To33(matrix m) {
  return matrix33(matrix(m[0][0], m[0][1], m[0][2], 0, m[1][0], m[1][1], m[1][2], 0, m[2][0], m[2][1], m[2][2], 0, 0, 0,
                         0, 1));
}
matrix33 __operator__neg__(matrix33 a) { return matrix33(-a.m); }
matrix33 __operator__mul__(matrix33 a, matrix33 b) { return matrix33(a.m * b.m); }
matrix33 __operator__mul__(matrix33 a, float b) { return matrix33(a.m * b); }
matrix33 __operator__mul__(float a, matrix33 b) { return matrix33(a * b.m); }
matrix33 __operator__mul__(matrix33 a, int b) { return matrix33(a.m * b); }
matrix33 __operator__mul__(int a, matrix33 b) { return matrix33(a * b.m); }
matrix33 __operator__div__(matrix33 a, matrix33 b) { return matrix33(a.m / b.m); }
matrix33 __operator__div__(matrix33 a, float b) { return matrix33(a.m / b); }
matrix33 __operator__div__(float a, matrix33 b) { return matrix33(a / b.m); }
matrix33 __operator__div__(matrix33 a, int b) { return matrix33(a.m / b); }
matrix33 __operator__div__(int a, matrix33 b) { return matrix33(a / b.m); }
int __operator__eq__(matrix33 a, matrix33 b) { return a.m == b.m; }
int __operator__ne__(matrix33 a, matrix33 b) { return a.m != b.m; }
float determinant(matrix33 a) { return determinant(a.m); }
matrix33 transpose(matrix33 a) { return matrix33(transpose(a.m)); }
point transform(matrix33 a, point p) { return transform(a.m, p); }
vector transform(matrix33 a, vector v) { return transform(a.m, v); }
normal transform(matrix33 a, normal n) { return transform(a.m, n); }
)";

// wireframe(): 1 on lines along the edges of the face that the point lies on, where the renderer gives its corners.
// The width is that of the whole line, half of which lies on the neighbour, in pixels or in units of the world.
constexpr char kUtil[] = R"(#define OSLUTIL_H
float wireframe(string edge_type, float line_width, int raster) {
  point corners[64];
  int count = 0;
  if (edge_type == "triangles")
    count = getattribute("geom:trianglevertices", corners) ? 3 : 0;
  else if ((edge_type == "polygons" || edge_type == "patches") && getattribute("geom:numpolyvertices", count))
    count = getattribute("geom:polyvertices", corners) ? min(count, 64) : 0;
  float reach = 0.5 * line_width;
  if (raster) {
    vector across = Dx(P) - dot(Dx(P), I) * I, down = Dy(P) - dot(Dy(P), I) * I;
    reach *= 0.5 * (length(across) + length(down));
  }
  for (int i = 0; i < count; ++i)
    if (distance(corners[i], corners[(i + 1) % count], P) < reach) return 1.0;
  return 0.0;
}
float wireframe(string edge_type, float line_width) { return wireframe(edge_type, line_width, 1); }
float wireframe(string edge_type) { return wireframe(edge_type, 1.0, 1); }
float wireframe() { return wireframe("polygons", 1.0, 1); }
)";

}  // namespace

std::string_view preludeHeader(std::string_view name) {
  if (const size_t slash = name.rfind('/'); slash != std::string_view::npos) name.remove_prefix(slash + 1);
  static const std::string kVector2 = vectorHeader({"vector2", {{"float", "x"}, {"float", "y"}}}),
                           kVector4 = vector4Header(),
                           kColor2 = shapeHeader({"color2", {{"float", "r"}, {"float", "a"}}}),
                           kColor4 = color4Header();
  if (name == "vector2.h") return kVector2;
  if (name == "vector4.h") return kVector4;
  if (name == "color2.h") return kColor2;
  if (name == "color4.h") return kColor4;
  if (name == "matrix33.h") return kMatrix33;
  if (name == "oslutil.h") return kUtil;
  return {};
}

}  // namespace kinora::language::front
