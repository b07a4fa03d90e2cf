// Surfaces of lights whose geometry is displaced (PxrMeshLight, AreaLightSource), as meshes. No camera decides how
// finely they are cut: light that they send is the same wherever it is seen from. Called by WorldBuilder, before the
// lights are made.
#pragma once
#include <map>
#include <memory>
#include <vector>

#include "render/displacement.h"

namespace kinora::render {

class LightSurfaces {
 public:
  using ByLight = std::map<const scene::Light*, std::shared_ptr<const geometry::Mesh>>;
  // Of those of `sources` that are displaced. Meshes are kept from one world to the next.
  ByLight make(const std::vector<scene::Light>& sources, const Displacement::Tools& tools, const RenderSpace& space,
               const std::atomic<bool>* stop);
  // What was made of files may not be taken for the same again.
  void forget() {
    displacement_.forget();
    kept_.clear();
  }

 private:
  std::shared_ptr<const geometry::Mesh> displaced(size_t shape, const scene::Primitive& primitive,
                                                  const Displacement::Tools& tools,
                                                  const std::atomic<bool>* stop) const;

  Displacement displacement_;
  std::map<Digest, std::shared_ptr<const geometry::Mesh>> kept_;
};

}  // namespace kinora::render
