#include "plugin/refused.h"

#include "base/text.h"

namespace kinora {

namespace {

constexpr const char* kBake = "nothing is baked";

constexpr RefusedPlugin kTable[] = {
    {Kind::Bxdf, "PxrHair", "its parameters are not published", "PxrMarschnerHair"},
    {Kind::Bxdf, "PxrLMLayer", "its layers are not taken apart", "PxrSurface, or LamaLayer"},
    {Kind::Bxdf, "PxrLMMixer", "its layers are not taken apart", "PxrLayerSurface, or LamaMix"},
    {Kind::Pattern, "PxrBakePointCloud", kBake, ""},
    {Kind::Pattern, "PxrBakeTexture", kBake, ""},
    {Kind::Pattern, "PxrBumpRoughness", "maps of slopes and their variance are not made yet", "PxrBump"},
    {Kind::Pattern, "PxrColorSpace", "colour spaces of patterns are not known yet", "transformc() of a shader"},
    {Kind::Pattern, "PxrGrid", "it is not published", "PxrChecker, PxrTileManifold"},
    {Kind::Pattern, "PxrLayeredTexture", "it is not made yet", "PxrTexture with PxrLayeredBlend"},
    {Kind::Pattern, "PxrPhasorNoise", "it is not made yet", "PxrFractal, PxrWorley"},
    {Kind::Pattern, "PxrProjectionLayer", "it is not made yet", "PxrProjector with PxrTexture"},
    {Kind::Pattern, "PxrPtexture", "there is no reader of Ptex files", "PxrTexture"},
    {Kind::Pattern, "PxrShadedSide", "it is not made yet", "PxrVariable"},
    {Kind::Pattern, "PxrSplineMap", "it is not made yet", "PxrRamp"},
    {Kind::Pattern, "PxrWireframe", "patterns do not know the edges of what is drawn", "PxrVisualizer shows them"},
    {Kind::LightFilter, "PxrCheatShadowLightFilter", "shadows are where they are", ""},
    {Kind::Integrator, "PxrDebugShadingContext", "its channels are those of displays", "PxrVisualizer"},
    {Kind::Integrator, "PxrUPBP", "PxrVCM has its techniques, see mergeMedia", "PxrVCM"},
    {Kind::SampleFilter, "PxrCryptomatte", "coverage by name is not kept yet", "the channels id and id2"},
};

}  // namespace

std::span<const RefusedPlugin> refusedPlugins() { return kTable; }

std::string adviceOnMissing(Kind kind, std::string_view name) {
  for (const RefusedPlugin& r : kTable)
    if (r.kind == kind && sameName(r.name, name))
      return std::string("not in this version: ") + r.why + (*r.instead ? std::string("; use ") + r.instead : "");
  return "is its library on the plug-in path?";
}

}  // namespace kinora
