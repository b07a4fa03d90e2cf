// PxrTee: hands on what it gets. The renderer writes the value to the display channel that has the name for its source,
// at what the camera sees; the node must lie on the way to the surface.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrTee/PxrTee.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kInputRGB, kInputF };
constexpr Param kParams[] = {
    param::color("inputRGB", 0.f).help("Colour that goes through to resultRGB."),
    param::number("inputF", 0.f).help("Number that goes through to resultF."),
    param::string("aov", "").help("Source of the display channel that shows it: the colour where resultRGB or one of "
                                  "its parts is connected, else the number."),
    param::integer("verbosity", 0).range(0, 2).help("Accepted."),
    KINORA_COLOR_OUTPUTS,
    param::output(Type::Float, "resultF"),
};

struct PxrTee {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    args->outputs[0] = c->param(kInputRGB);
    shareComponents(*args, 0);
    args->outputs[4] = c->param(kInputF);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrTee, .help = "Hands a value on and shows it in a display channel.", .params = kParams)
