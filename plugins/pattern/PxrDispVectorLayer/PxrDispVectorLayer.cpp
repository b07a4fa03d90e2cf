// PxrDispVectorLayer: vectors of displacement, four layers on a base.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrDispVectorLayer/PxrDispVectorLayer.cpp"
#include "plugins/pattern/displacement_layers.h"

KINORA_KERNELS_BEGIN

#define KINORA_OFFSET(name, of) param::vector(name, 0, 0, 0).help("Offset of " of ".")
constexpr Param kParams[] = {
    KINORA_DISPLACEMENT_LAYERS("DispVector", KINORA_OFFSET),
    param::output(Type::Vector, "resultXYZ"),
    param::output(Type::Float, "resultX"),
    param::output(Type::Float, "resultY"),
    param::output(Type::Float, "resultZ"),
};
#undef KINORA_OFFSET

using PxrDispVectorLayer = DisplacementLayers<3>;

KINORA_KERNELS_END

KINORA_PATTERN(PxrDispVectorLayer, .help = "Vectors of displacement in layers, for a displacement.",
               .params = kParams)
