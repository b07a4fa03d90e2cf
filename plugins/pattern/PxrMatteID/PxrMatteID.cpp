// PxrMatteID: kept for the scenes that have it. It hands on nothing; its channels MatteID0 ... MatteID7 are not made.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrMatteID/PxrMatteID.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

#define KINORA_MATTE(n) \
  param::color("matteTexture" #n, 0.f).help("No effect yet. What the channel MatteID" #n " shows.")
constexpr Param kParams[] = {
    param::integer("inputAOV", 0).help("Accepted: the order of such nodes."),
    param::integer("enable", 1).range(0, 1).help("No effect: there is nothing to switch off."),
    KINORA_MATTE(0),
    KINORA_MATTE(1),
    KINORA_MATTE(2),
    KINORA_MATTE(3),
    KINORA_MATTE(4),
    KINORA_MATTE(5),
    KINORA_MATTE(6),
    KINORA_MATTE(7),
    param::output(Type::Int, "resultAOV"),
};
#undef KINORA_MATTE

struct PxrMatteID {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    const float none = 0.f;
    args->outputs[0] = constantValue(*c, 1, &none);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrMatteID, .help = "Kept: its mattes are not made.", .params = kParams)
