#include "render/frame_plan.h"

#include <utility>

#include "scene/digests.h"

namespace kinora::render {

namespace {

// The first colour again, once for each half of the samples.
void addHalves(FramePlan& f) {
  f.halves = {-1, -1};
  const int c = firstColor(f.displays.layout);
  if (c < 0) return;
  film::Channel k = f.displays.layout[c];
  if (k.source.empty()) k.source = k.name;
  k.splats = false;
  for (const film::Half half : {film::Half::Even, film::Half::Odd}) {
    k.half = half;
    k.name = half == film::Half::Even ? "__even" : "__odd";
    f.halves[half == film::Half::Even ? 0 : 1] = f.displays.layout.add(k);
  }
}

// Expressions that cannot be had as they are written.
void warnOfPaths(const FramePlan& f, const scene::Scene& scene, Diagnostics& diagnostics) {
  for (const uint16_t i : f.paths->unmatched()) {
    const std::string what = "the light path expression \"" + f.record.sources[i] + "\" ";
    if (f.paths->isTooLarge())
      diagnostics.warning("LPE-SIZE", scene.pos, what + "is too large together with the others",
                          "its channel stays black", "fewer repetitions ({n,m}), labels and channels need less");
    else
      diagnostics.warning(
          "LPE-EMPTY", scene.pos, what + "matches no light path", "its channel stays black",
          "paths end with L, a light, or O, a glowing surface or a light that the camera sees itself");
  }
  if (f.paths->tails().isTooLarge())
    diagnostics.warning("LPE-SIZE", scene.pos,
                        "the light path expressions together tell too many paths from the lights apart",
                        "some of their light goes to channels as if it had met fewer surfaces",
                        "fewer repetitions ({n,m}), labels and channels need less");
}

void makeRatios(const scene::Scene& scene, Diagnostics& diagnostics, FramePlan& plan) {
  const bool jitters = hasJitter(scene);
  plan.displays.layout.setNegative(-1, jitters ? plan.filter.negativeMean() : 0);
  for (const film::ChannelFilter& f : plan.displays.layout.filters()) {
    film::PixelFilter own;
    if (!film::PixelFilter::make(f.name, f.xWidth, f.yWidth, own).ok()) own = plan.filter;  // checked by the plan
    plan.ratios.emplace_back(plan.filter, own);
    plan.displays.layout.setNegative(int(plan.ratios.size()) - 1, jitters ? plan.ratios.back().negativeMean() : 0);
    if (plan.ratios.back().covered() < 0.98)
      diagnostics.warning("DISPLAY-CHANNEL-FILTER", scene.pos,
                          "the filter \"" + f.name + "\" of a channel reaches beyond the frame's pixel filter \"" +
                              plan.filter.name() + "\"",
                          "it is cut there", "give PixelFilter the widest filter of the frame");
  }
}

}  // namespace

int firstColor(const film::ChannelLayout& layout) {
  for (int c = 0; c < layout.size(); ++c) {
    const film::Channel& k = layout[c];
    if (k.type == film::ChannelType::Color && !k.isData && k.reducer == film::Reducer::Sum) return c;
  }
  return -1;
}

bool hasJitter(const scene::Scene& scene) { return !scene.hider || scene.hider->params.getInt("jitter", 1) != 0; }

film::DriverLookup displayDrivers(Registry& registry, Diagnostics& diagnostics) {
  return [&](const std::string& name) { return registry.find(Kind::Display, name, diagnostics, {}); };
}

std::unique_ptr<FramePlan> planFrame(const scene::Scene& scene, const Settings& settings, bool hasLightStage,
                                     bool needsSplit, const FramePlan* before, Registry& registry,
                                     WorldBuilder& builder, Diagnostics& diagnostics) {
  auto made = std::make_unique<FramePlan>();
  FramePlan& f = *made;
  const FileContents::Listening listening(builder.contents(), f.files);
  film::PlanOptions options;
  // of a part -o names the part; its pictures stay the scene's
  options.isPart = settings.firstSample >= 0;
  if (!options.isPart) options.output = settings.output;
  options.splats = hasLightStage;
  f.displays = film::planDisplays(scene, options, displayDrivers(registry, diagnostics), diagnostics);
  if (!options.output.empty())
    film::keepBeside(f.displays, film::fillFrame(options.output, scene.frame), diagnostics);
  if (!f.displays.isWritable) return nullptr;
  if (options.isPart && !f.displays.displayFilters.empty())
    f.displays.texturePath = builder.searchPath(scene, "texture");
  makePixelFilter(scene, registry, builder.host(), diagnostics, f.filter);
  if (settings.errorMap && settings.firstSample < 0) addHalves(f);
  const int* resolution = builder.camera().resolution.data();
  const ChannelFilterInfo picture{{uint32_t(resolution[0]), uint32_t(resolution[1])}, f.displays.pixelAspect};
  f.sampleFilters.make(Kind::SampleFilter, scene.sampleFilters, f.displays.layout, picture, registry, builder.host(),
                       builder.width(), diagnostics);
  if (hasLightStage && !f.sampleFilters.empty())
    diagnostics.warning(
        "FILTER-SPLATS", scene.sampleFilters.front()->pos,
        "sample filters see what camera paths bring; light that paths from the lights bring to pixels passes "
        "them by",
        "that part of the picture is not filtered",
        "a display filter sees the whole picture; or take an integrator without light paths");
  f.displayFilters.make(Kind::DisplayFilter, scene.displayFilters, f.displays.layout, picture, registry,
                        builder.host(), builder.width(), diagnostics);
  f.record = planRecord(f.displays.layout);
  Hasher h;
  h.digest(scene::digestOf(scene.options));
  h.word(uint64_t(needsSplit) | uint64_t(hasLightStage) << 1);
  for (const std::string& source : f.record.sources) h.text(source);
  f.ofPaths = h.result();
  // materials are bound to light paths: the same ones stay
  if (before && before->ofPaths == f.ofPaths)
    f.paths = before->paths;
  else
    f.paths = std::make_shared<film::LightPaths>(f.record.sources, needsSplit, film::LobeNumbers(scene.options),
                                                 hasLightStage);
  addUserLobes(*f.paths, f.record);
  warnOfPaths(f, scene, diagnostics);
  makeRatios(scene, diagnostics, f);
  return made;
}

Digest framePlanDigestOf(const scene::Scene& scene, const CameraState& camera, bool hasLightStage, bool needsSplit) {
  Hasher h;
  for (const int n : camera.resolution) h.word(uint64_t(n));
  h.bytes(&scene.pixelAspect, sizeof scene.pixelAspect);
  h.digest(scene::frameDigestOf(scene));
  h.word(uint64_t(hasLightStage) | uint64_t(needsSplit) << 1);
  return h.result();
}

}  // namespace kinora::render
