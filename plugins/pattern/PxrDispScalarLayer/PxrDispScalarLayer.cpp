// PxrDispScalarLayer: distances along the normal, four layers on a base.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrDispScalarLayer/PxrDispScalarLayer.cpp"
#include "plugins/pattern/displacement_layers.h"

KINORA_KERNELS_BEGIN

#define KINORA_DISTANCE(name, of) param::number(name, 0.f).range(-1, 1).help("Distance of " of "; object units.")
constexpr Param kParams[] = {
    KINORA_DISPLACEMENT_LAYERS("DispScalar", KINORA_DISTANCE),
    param::output(Type::Float, "resultF"),
};
#undef KINORA_DISTANCE

using PxrDispScalarLayer = DisplacementLayers<1>;

KINORA_KERNELS_END

KINORA_PATTERN(PxrDispScalarLayer, .help = "Distances along the normal in layers, for a displacement.",
               .params = kParams)
