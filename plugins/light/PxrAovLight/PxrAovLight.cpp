// PxrAovLight: a light that lights nothing and marks what it is linked to in a channel, so that masks can be made by
// light linking. Light filters on it change the mark.
#define KINORA_KERNEL_FILE "plugins/light/PxrAovLight/PxrAovLight.cpp"
#include <kinora/light_setup.h>
#include <memory>
#include <kinora/light_author.h>

#if KINORA_PLAIN
namespace kinora::pxrAovLight {
constexpr std::array kParams = {
    param::string("aovName", "").help("Source of the display channel that gets the mark; lights of one name add up."),
    param::onOff("inPrimaryHit", true).help("Marks surfaces that the camera sees."),
    param::onOff("inReflection", false).help("Marks surfaces that specular reflections show, one behind the other."),
    param::onOff("inRefraction", false)
        .help("Marks surfaces seen through specular refraction, through any number of surfaces."),
    param::onOff("invert", false).help("1: marks the surfaces that the light is not linked to."),
    param::onOff("onVolumeBoundaries", true)
        .help("No effect: what the camera sees of a medium has no boundary; surfaces around media are marked as "
              "others."),
    param::onOff("useColor", false).help("0: the mark is the luminance of the colour."),
    param::onOff("useThroughput", true)
        .help("1: in reflections and refractions the mark is weighed by what they pass on, 0: it is all or nothing."),
    param::number("intensity", 1.f).range(0, 100).help("Factor on the mark."),
    param::number("exposure", 0.f).range(-8, 8).help("Stops: the mark is multiplied by 2 to this power."),
    param::color("lightColor", 1.f).help("Colour of the mark."),
};
struct Data {
  std::string channel;
  LightMark mark{};
  explicit Data(const CreateInfo& info) {
    const NamedValues v(info, kParams.data(), kParams.size());
    channel = v.string("aovName");
    const double scale = v.number("intensity") * std::exp2(v.number("exposure"));
    const double grey =
        0.2126 * v.number("lightColor", 0) + 0.7152 * v.number("lightColor", 1) + 0.0722 * v.number("lightColor", 2);
    for (int c = 0; c < 3; ++c)
      mark.color[c] = float(scale * (v.integer("useColor") ? v.number("lightColor", c) : grey));
    mark.inFirst = v.integer("inPrimaryHit");
    mark.inReflection = v.integer("inReflection");
    mark.inRefraction = v.integer("inRefraction");
    mark.isInverted = v.integer("invert");
    mark.isWeighted = v.integer("useThroughput");
  }
};
void describe(const void*, LightDescription* d) {
  d->radius = -1;
  d->isInfinite = 1;
}
void mark(const void* data, LightMark* out) {
  const Data& k = *static_cast<const Data*>(data);
  *out = k.mark;
  out->channel = k.channel.c_str();
}
}  // namespace kinora::pxrAovLight
#endif

KINORA_KERNELS_BEGIN
struct PxrAovLight : MarkingLight<pxrAovLight::Data> {};
KINORA_KERNELS_END

KINORA_LIGHT(PxrAovLight, .help = "Lights nothing and marks what it is linked to in a display channel.",
             .params = pxrAovLight::kParams, .setUp = setUp<pxrAovLight::Data>, .describe = pxrAovLight::describe,
             .mark = pxrAovLight::mark)
