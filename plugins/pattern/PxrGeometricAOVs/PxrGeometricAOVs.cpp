// PxrGeometricAOVs: kept for the scenes that have it. The channels that it asks for elsewhere (__Pworld, __Nworld,
// __depth, __st; primitive variables by name: __Pref, __Nref ...) are sources of display channels here without it.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrGeometricAOVs/PxrGeometricAOVs.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

constexpr Param kParams[] = {
    param::make(Type::Int, "inputAOV", 0, 0, 0).help("Another such node, which is then there as well."),
    param::flag("usePref", false).help("No effect: a channel of source __Pref shows that variable."),
    param::output(Type::Int, "resultAOV"),
};

struct PxrGeometricAOVs {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    const float none = 0.f;
    args->outputs[0] = constantValue(*c, 1, &none);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrGeometricAOVs, .help = "Kept: channels of positions, normals and coordinates need no node.",
               .params = kParams)
