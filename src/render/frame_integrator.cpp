#include "render/frame_integrator.h"

#include <algorithm>
#include <string>

#include "plugin/refused.h"
#include "render/frame.h"
#include "render/overrides.h"
#include "scene/digests.h"

namespace kinora::render {

bool FrameIntegrator::make(const scene::Scene& scene, Registry& registry, WorldBuilder& builder,
                           Diagnostics& diagnostics, Rebuilt& rebuilt) {
  const scene::Node* node = scene.integrator.get();
  const std::string name = node ? node->plugin : defaultIntegrator(scene);
  Hasher h;
  h.text(name);
  h.digest(scene::digestOf(scene.integrator));
  const Digest digest = h.result();
  if (instance_.plugin() && digest == of_) {
    builder.contents().again(files_);
    return true;
  }
  of_ = digest;
  files_.clear();
  const FileContents::Listening listening(builder.contents(), files_);
  ++rebuilt.integrators;
  const Descriptor* d = registry.find(Kind::Integrator, name, diagnostics, node ? node->pos : SourcePos{});
  if (!d) {
    diagnostics.warning("PLUGIN-MISSING", node ? node->pos : scene.pos, "no integrator '" + name + "'",
                        "PxrPathTracer stands in", adviceOnMissing(Kind::Integrator, name));
    d = registry.find(Kind::Integrator, "PxrPathTracer", diagnostics, {});
    node = nullptr;
  }
  if (d && instance_.create(*d, node, nullptr, nullptr, builder.host(), diagnostics)) return true;
  d = registry.find(Kind::Integrator, "PxrPathTracer", diagnostics, {});
  return d && instance_.create(*d, nullptr, nullptr, nullptr, builder.host(), diagnostics);
}

bool FrameIntegrator::hasLightStage() const {
  const auto* traits = static_cast<const IntegratorTraits*>(plugin().traits);
  if (!traits || !traits->stages) return false;
  Stage list[16];
  const uint32_t n = std::min(traits->stages(instance_.data(), list, 16), 16u);
  return std::any_of(list, list + n, [](const Stage& s) { return s.kind == StageKind::LightPaths; });
}

bool FrameIntegrator::tellsLobesApart() const {
  const auto* traits = static_cast<const IntegratorTraits*>(plugin().traits);
  return traits && traits->tellsLobesApart && traits->tellsLobesApart(instance_.data());
}

int FrameIntegrator::passSamples() const { return Frame::passSamplesOf(plugin(), instance_.data()); }

std::vector<SetAsker> FrameIntegrator::setAskers(const scene::Scene& scene) const {
  return setAskersOf(plugin(), scene.integrator.get());
}

AggregateChoice FrameIntegrator::aggregates(const scene::Scene& scene) const {
  return aggregatesOf(plugin(), scene.integrator.get());
}

}  // namespace kinora::render
