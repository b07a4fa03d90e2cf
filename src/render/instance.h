// The data that a plug-in makes for one node of the scene, and the host that it asks for images and speaks through
// while it makes it. Used by all of render/ that makes plug-ins: projections, integrators, lights, filters.
#pragma once
#include <memory>
#include <string>

#include "base/diagnostics.h"
#include "plugin/registry.h"
#include "scene/scene.h"

namespace kinora {
class TextureSystem;
namespace render {

// What plug-ins see of the renderer. Texture system and diagnostics must outlive it.
class PluginHost {
 public:
  PluginHost(Diagnostics& diagnostics, TextureSystem* textures);
  PluginHost(const PluginHost&) = delete;
  const Host& host() const { return host_; }
  void setTextures(TextureSystem* textures) { parts_.textures = textures; }

  struct Parts {
    Diagnostics* diagnostics;
    TextureSystem* textures;
  };

 private:
  Parts parts_;
  Host host_;
};

// A plug-in's data for one node, destroyed with it.
class Instance {
 public:
  Instance() = default;
  // False with a message when create() fails.
  bool create(const Descriptor& plugin, const scene::Node* node, const Placement* placement, const void* extra,
              const Host& host, Diagnostics& diagnostics);
  const Descriptor* plugin() const { return plugin_; }
  const void* data() const { return data_.get(); }
  std::shared_ptr<void> owner() const { return data_; }

 private:
  const Descriptor* plugin_ = nullptr;
  std::shared_ptr<void> data_;
};

}  // namespace render
}  // namespace kinora
