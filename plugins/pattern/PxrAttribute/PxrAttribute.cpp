// PxrAttribute: an attribute of the object. The renderer runs it as a shader, which can ask for attributes; what stands
// here is what a host without a shading language gives: the defaults.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrAttribute/PxrAttribute.cpp"
#include <string_view>
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kVarname, kType, kDefaultInt, kDefaultFloat, kDefaultFloat3, kDefaultColor, kVerbosity };
constexpr Param kParams[] = {
    param::string("varname", "").help("Name of the attribute, as \"user:dirt\"."),
    param::string("type", "float")
        .options("int|float|float2|color|point|vector|normal")
        .help("What the attribute holds."),
    param::integer("defaultInt", 0).help("Where there is no such attribute: of type int."),
    param::number("defaultFloat", 0.f).help("Where there is none: of type float."),
    param::vector("defaultFloat3", 0, 0, 0).help("Where there is none: of types float2, point, vector and normal."),
    param::color("defaultColor", 0.f).help("Where there is none: of type color."),
    param::integer("verbosity", 0).range(0, 2).help("Accepted."),
    KINORA_COLOR_OUTPUTS,
    param::output(Type::Float, "resultF"),
    param::output(Type::Int, "resultI"),
};

struct PxrAttribute {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    const std::string_view type = c->fn->text(c, kType);
    const Value v = c->param(type == "color"   ? kDefaultColor
                             : type == "float" ? kDefaultFloat
                             : type == "int"   ? kDefaultInt
                                               : kDefaultFloat3);
    Value& rgb = args->outputs[0];
    rgb = v;
    rgb.components = 3;
    for (uint32_t k = v.components; k < 3; ++k) rgb.data[k] = v.data[0];
    shareComponents(*args, 0);
    shareComponent(v, 0, args->outputs[4]);
    shareComponent(v, 0, args->outputs[5]);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrAttribute, .help = "Reads an attribute of the object.", .params = kParams)
