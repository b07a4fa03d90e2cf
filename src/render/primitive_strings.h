// Names of files that each object completes with a word of its own: "<primstr:NAME>" in a string of a material's network
// is the constant string primvar NAME of the primitive. Objects of one word share a network, and so a material. Called while
// materials are asked for (materials.cpp).
#pragma once
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "scene/scene.h"

namespace kinora::render {

class PrimitiveStrings {
 public:
  explicit PrimitiveStrings(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}
  // `network` itself where it has no such token.
  scene::NetworkPtr completed(const scene::NetworkPtr& network, const scene::Primitive& primitive);

 private:
  const std::vector<std::string>& namesIn(const scene::NetworkPtr& network);

  Diagnostics& diagnostics_;
  std::map<scene::NetworkPtr, std::vector<std::string>> names_;
  std::map<std::pair<scene::NetworkPtr, std::vector<std::string>>, scene::NetworkPtr> made_;
};

}  // namespace kinora::render
