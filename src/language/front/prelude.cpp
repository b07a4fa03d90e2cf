#include "language/front/prelude.h"

#include <utility>

namespace kinora::language::front {

std::string_view preludeMacros() {
  return R"(#define OSL_VERSION_MAJOR 1
#define OSL_VERSION_MINOR 14
#define OSL_VERSION_PATCH 0
#define OSL_VERSION 11400
#define M_PI 3.1415926535897932
#define M_PI_2 1.5707963267948966
#define M_PI_4 0.7853981633974483
#define M_2_PI 0.6366197723675813
#define M_2PI 6.2831853071795865
#define M_4PI 12.566370614359173
#define M_2_SQRTPI 1.1283791670955126
#define M_E 2.7182818284590452
#define M_LN2 0.6931471805599453
#define M_LN10 2.3025850929940457
#define M_LOG2E 1.4426950408889634
#define M_LOG10E 0.4342944819032518
#define M_SQRT2 1.4142135623730950
#define M_SQRT1_2 0.7071067811865475
)";
}

namespace {

// formulas: reference osl-numerics, section 8
constexpr std::pair<std::string_view, std::string_view> kFunctions[] = {
    {"hypot", R"(
float hypot(float x, float y) { return sqrt(x * x + y * y); }
float hypot(float x, float y, float z) { return sqrt(x * x + y * y + z * z); }
)"},
    {"distance", R"(
float distance(point a, point b, point q) {
  vector d = b - a;
  float dd = dot(d, d);
  if (dd == 0.0) return distance(q, a);
  return distance(a + clamp(dot(q - a, d) / dd, 0.0, 1.0) * d, q);
}
)"},
    {"fresnel", R"(
void fresnel(vector I, normal N, float eta, output float Kr, output float Kt) {
  float c = fabs(dot(I, N));
  float g2 = 1.0 / (eta * eta) - 1.0 + c * c;
  if (g2 < 0.0) {
    Kr = 1.0;
    Kt = 0.0;
  } else {
    float g = sqrt(g2);
    float b = (g - c) / (g + c);
    float f = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
    Kr = 0.5 * b * b * (1.0 + f * f);
    Kt = (1.0 - Kr) * eta * eta;
  }
}
void fresnel(vector I, normal N, float eta, output float Kr, output float Kt, output vector R, output vector T) {
  float c = fabs(dot(I, N));
  float g2 = 1.0 / (eta * eta) - 1.0 + c * c;
  R = reflect(I, N);
  if (g2 < 0.0) {
    Kr = 1.0;
    Kt = 0.0;
    T = vector(0.0);
  } else {
    float g = sqrt(g2);
    float b = (g - c) / (g + c);
    float f = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
    Kr = 0.5 * b * b * (1.0 + f * f);
    Kt = (1.0 - Kr) * eta * eta;
    T = refract(I, N, eta);
  }
}
)"},
    {"aastep", R"(
float aastep(float edge, float s, float dedge, float ds) {
  float width = fabs(dedge) + fabs(ds);
  float half_width = 0.5 * width;
  float e1 = edge - half_width;
  return s <= e1 ? 0.0 : (s >= edge + half_width ? 1.0 : (s - e1) / width);
}
float aastep(float edge, float s, float ds) { return aastep(edge, s, filterwidth(edge), ds); }
float aastep(float edge, float s) { return aastep(edge, s, filterwidth(edge), filterwidth(s)); }
)"},
    {"mix", R"(
closure color mix(closure color a, closure color b, float x) { return a * (1.0 - x) + b * x; }
closure color mix(closure color a, closure color b, color x) { return a * (color(1.0) - x) + b * x; }
)"},
    {"transformu", R"(
float transformu(string fromunits, string tounits, float x) {
  string names[7] = {"mm", "cm", "m", "km", "in", "ft", "mi"};
  float metres[7] = {0.001, 0.01, 1.0, 1000.0, 0.0254, 0.3048, 1609.344};
  float from_scale = fromunits == "common" ? 1.0 : 0.0;
  float to_scale = tounits == "common" ? 1.0 : 0.0;
  for (int i = 0; i < 7; ++i) {
    if (fromunits == names[i]) from_scale = metres[i];
    if (tounits == names[i]) to_scale = metres[i];
  }
  if (from_scale == 0.0 || to_scale == 0.0) {
    error("transformu: unknown unit \"%s\"", from_scale == 0.0 ? fromunits : tounits);
    return x;
  }
  return x * from_scale / to_scale;
}
float transformu(string tounits, float x) { return transformu("common", tounits, x); }
)"},
    {"displace", R"(
void displace(vector offset) { P += offset; N = normalize(calculatenormal(P)); }
void displace(float amp) { displace(amp * normalize(N)); }
void displace(string space, float amp) {
  vector n = normalize(N);
  displace(amp * n / length(transform(space, n)));
}
)"},
    {"bump", R"(
void bump(vector offset) { N = normalize(calculatenormal(P + offset)); }
void bump(float amp) { bump(amp * normalize(N)); }
void bump(string space, float amp) {
  vector n = normalize(N);
  bump(amp * n / length(transform(space, n)));
}
)"},
    // older names of raytype()
    {"iscameraray", "int iscameraray() { return raytype(\"camera\"); }\n"},
    {"isdiffuseray", "int isdiffuseray() { return raytype(\"diffuse\"); }\n"},
    {"isglossyray", "int isglossyray() { return raytype(\"glossy\"); }\n"},
    {"isshadowray", "int isshadowray() { return raytype(\"shadow\"); }\n"},
    {"isreflectionray", "int isreflectionray() { return raytype(\"reflection\"); }\n"},
    {"isrefractionray", "int isrefractionray() { return raytype(\"refraction\"); }\n"},
    // Gulbrandsen 2014, "Artist Friendly Metallic Fresnel"
    {"artistic_ior", R"(
void artistic_ior(color reflectivity, color edge_tint, output color ior, output color extinction) {
  color r = clamp(reflectivity, color(0.0), color(0.99));
  color s = sqrt(r);
  color n_min = (1.0 - r) / (1.0 + r);
  color n_max = (1.0 + s) / (1.0 - s);
  ior = mix(n_max, n_min, edge_tint);
  color np1 = ior + 1.0;
  color nm1 = ior - 1.0;
  extinction = sqrt(max((r * np1 * np1 - nm1 * nm1) / (1.0 - r), color(0.0)));
}
)"},
};

}  // namespace

std::string_view preludeFunction(std::string_view name) {
  for (const auto& [own, text] : kFunctions)
    if (own == name) return text;
  return {};
}

std::vector<std::string_view> preludeFunctionNames() {
  std::vector<std::string_view> names;
  for (const auto& f : kFunctions) names.push_back(f.first);
  return names;
}

}  // namespace kinora::language::front
