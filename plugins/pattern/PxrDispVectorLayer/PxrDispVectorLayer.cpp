// PxrDispVectorLayer: vectors of displacement, four layers on a base.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrDispVectorLayer/PxrDispVectorLayer.cpp"
#include "plugins/pattern/displacement_layers.h"

KINORA_KERNELS_BEGIN

#define KINORA_OFFSET(name, of) param::vector(name, 0, 0, 0).help("Offset of " of ".")
constexpr Param kParams[] = {
    KINORA_DISPLACEMENT_BASE(KINORA_OFFSET("baseLayerDispVector", "the base")),
    KINORA_DISPLACEMENT_LAYER("1", 1, KINORA_OFFSET("layer1DispVector", "layer 1")),
    KINORA_DISPLACEMENT_LAYER("2", 0, KINORA_OFFSET("layer2DispVector", "layer 2")),
    KINORA_DISPLACEMENT_LAYER("3", 0, KINORA_OFFSET("layer3DispVector", "layer 3")),
    KINORA_DISPLACEMENT_LAYER("4", 0, KINORA_OFFSET("layer4DispVector", "layer 4")),
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
