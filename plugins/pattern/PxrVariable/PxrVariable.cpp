// PxrVariable: a built-in variable by name. Unknown names give 0 0 0 (and PARAM-CHOICE says so).
#define KINORA_KERNEL_FILE "plugins/pattern/PxrVariable/PxrVariable.cpp"
#include <cstring>
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kVariable, kName, kType, kCoordsys };
constexpr const char* kNames =
    "P|Po|PO|Pworld|PW|N|Nn|Ng|Ngn|V|Vn|T|Tn|dPdu|du|dPdv|dv|u|U|v|uv|st|s|t|time|id|identifier:id|radius|PRadius";
constexpr Param kParams[] = {
    param::string("variable", "").options(kNames).help("Name of the variable; name counts where it is empty."),
    param::string("name", "").options(kNames).help("Name of the variable."),
    param::string("type", "float").help("Accepted; the variable's own type counts."),
    param::string("coordsys", "object").help("Space in which points, vectors and normals are given out."),
    KINORA_COLOR_OUTPUTS,
    param::output(Type::Float, "resultRadius"),
};

inline Value fromArrays(const float* const* p, uint32_t components) {
  Value v;
  v.stride = 1;
  v.components = components;
  for (uint32_t k = 0; k < components; ++k) v.data[k] = p[k];
  return v;
}

struct PxrVariable {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    const char* name = c->fn->text(c, kVariable);
    if (!name || !*name) name = c->fn->text(c, kName);
    const char* space = c->fn->text(c, kCoordsys);
    if (!space || !*space) space = "object";
    const float zeros[3] = {0, 0, 0};
    Value v, radius = fromArrays(&c->radius, 1);
    Moves how = Moves::No;
    const auto is = [name](const char* a, const char* b) { return !std::strcmp(name, a) || !std::strcmp(name, b); };
    if (is("P", "P")) {
      v = fromArrays(c->P, 3), how = Moves::Point;
    } else if (is("Po", "PO")) {
      v = c->builtin(Builtin::Po), radius = c->builtin(Builtin::PoRadius);
    } else if (is("Pworld", "PW")) {
      v = c->builtin(Builtin::Pworld);
    } else if (is("N", "Nn")) {
      v = fromArrays(c->N, 3), how = Moves::Normal;
    } else if (is("Ng", "Ngn")) {
      v = fromArrays(c->Ng, 3), how = Moves::Normal;
    } else if (is("V", "Vn")) {
      v = fromArrays(c->wo, 3), how = Moves::Vector;
    } else if (is("T", "Tn")) {
      v = c->builtin(Builtin::Tangent), how = Moves::Vector;
    } else if (is("dPdu", "du")) {
      v = c->builtin(Builtin::DPdu), how = Moves::Vector;
    } else if (is("dPdv", "dv")) {
      v = c->builtin(Builtin::DPdv), how = Moves::Vector;
    } else if (is("u", "U")) {
      v = c->builtin(Builtin::U);
    } else if (is("v", "v")) {
      v = c->builtin(Builtin::V);
    } else if (is("uv", "uv")) {
      const Value parts[2] = {c->builtin(Builtin::U), c->builtin(Builtin::V)};
      float* both[3] = {c->alloc<float>(c->padded), c->alloc<float>(c->padded), nullptr};
      for (uint32_t k = 0; k < 2; ++k)
        for (uint32_t i = 0; i < c->padded; ++i) both[k][i] = parts[k].data[0][i * parts[k].stride];
      v = fromArrays(both, 2);
    } else if (is("st", "s") || is("t", "t")) {
      v = c->builtin(Builtin::St), radius = c->builtin(Builtin::StRadius);
      if (is("t", "t")) v.data[0] = v.data[1];
      if (!is("st", "st")) v.components = 1;
    } else if (is("time", "time")) {
      v = fromArrays(&c->time, 1);
    } else if (is("id", "identifier:id")) {
      v = c->builtin(Builtin::ObjectId);
    } else if (is("radius", "PRadius")) {
      v = radius;
    } else {
      v = constantValue(*c, 3, zeros);
    }
    toSpace<W>(*c, space, how, v);
    // one number stands in all channels; two have no third
    Value& rgb = args->outputs[0];
    rgb = v;
    rgb.components = 3;
    const uint32_t n = v.components > 3 ? 3 : v.components;
    for (uint32_t k = n; k < 3; ++k) rgb.data[k] = v.data[n - 1];
    if (n == 2) {
      float* zero = c->alloc<float>(c->padded);
      for (uint32_t i = 0; i < c->padded; ++i) zero[i] = 0.f;
      rgb.data[2] = zero;
    }
    shareComponents(*args, 0);
    shareComponent(radius, 0, args->outputs[4]);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrVariable, .help = "Reads a built-in variable.", .params = kParams)
