// PxrPrimvar: a primitive variable by name, or a default where the object has none. Every output is filled whatever
// the declared type: a float stands in all components of a colour, a colour's float is its first component.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrPrimvar/PxrPrimvar.cpp"
#include <cstring>
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kVarname,
  kType,
  kCoordsys,
  kDefaultFloat,
  kDefaultFloat3,
  kTransformDefaults,
  kDefaultColor,
  kVerbosity
};
constexpr Param kParams[] = {
    param::string("varname", "").help("Name of the primitive variable."),
    param::string("type", "float").options("float|float2|color|point|vector|normal").help("What the variable holds."),
    param::string("coordsys", "object").help("Space in which points, vectors and normals are given out."),
    param::number("defaultFloat", 0.f).help("Where there is no such variable: of type float."),
    param::vector("defaultFloat3", 0, 0, 0).help("Where there is none: of types float2, point, vector and normal."),
    param::flag("transformDefaultValues", true).help("0: defaultFloat3 stands as given whatever coordsys is."),
    param::color("defaultColor", 0.f).help("Where there is none: of type color."),
    param::integer("verbosity", 0)
        .range(0, 2)
        .help("Accepted; messages are given once for each file and name anyway."),
    KINORA_COLOR_OUTPUTS,
    param::output(Type::Float, "resultF"),
    param::output(Type::Point, "resultP"),
    param::output(Type::Float, "width"),
};

struct PxrPrimvar {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    const char* type = c->fn->text(c, kType);
    const bool isColor = !std::strcmp(type, "color"), isFloat = !std::strcmp(type, "float");
    Primvar variable(*c, c->fn->text(c, kVarname));
    const Value otherwise = c->param(isColor ? kDefaultColor : isFloat ? kDefaultFloat : kDefaultFloat3);
    const float none = 0.f;
    const Value zero = constantValue(*c, 1, &none);
    // A default is written in the space asked for, so it is there already unless transformDefaultValues is off, when
    // it is left alone too.
    const Moves how = movesLike(type);
    Value rgb;
    if (how != Moves::No && variable.value.components == 3) {
      const char* space = c->fn->text(c, kCoordsys);
      rgb = placesOr<W>(*c, variable, space && *space ? space : "object", how, otherwise);
    } else {
      Value& v = variable.value;
      for (uint32_t k = 1; v.components == 1 && k < 3; ++k) v.data[k] = v.data[0];
      if (v.components == 2) {  // texture coordinates have no third component
        float* third = c->alloc<float>(c->padded);
        std::fill_n(third, c->padded, 0.f);
        v.data[2] = third;
      }
      if (v.components) v.components = 3;
      rgb = primvarOr(*c, variable, otherwise);
    }
    for (uint32_t k = rgb.components; k < 3; ++k) rgb.data[k] = rgb.data[rgb.components - 1];
    rgb.components = 3;
    args->outputs[0] = rgb;
    shareComponents(*args, 0);
    shareComponent(rgb, 0, args->outputs[4]);
    args->outputs[5] = rgb;
    args->outputs[6] = footprintOr(*c, variable, zero);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrPrimvar, .help = "Reads a primitive variable of the geometry.", .params = kParams)
