// What makes two renders the same frame: all that the scene says (scene/identity.h), what the files hold that it
// reads (textures, shaders, volumes, light maps, colour configuration), the plug-ins' libraries and the version of
// the program; not the seed, the samples, or how and where it is rendered. Made by Renderer when the world is built;
// its hash goes into every picture, the inventory into parts of a frame.
#pragma once
#include <vector>

#include "base/digest.h"
#include "base/file_contents.h"
#include "plugin/registry.h"
#include "scene/identity.h"

namespace kinora::render {

class FrameIdentity {
 public:
  // Of a world that was just built. Reads the files that were not read yet.
  void make(const scene::Scene& scene, FileContents& contents, const Registry& registry);
  const Digest& digest() const { return digest_; }
  // For parts of the frame: what the digest was made of. The scene is that of make().
  scene::Inventory inventory(const scene::Scene& scene) const;
  // Files that were first asked for while it was rendered: shaders make names as they go. Which ones depends on the
  // samples, so that the digest cannot know them.
  std::vector<FileContents::Entry> lateFiles(FileContents& contents) const;

 private:
  struct Fact {
    std::string kind, name;
    Digest content;
    auto operator<=>(const Fact&) const = default;
  };
  std::vector<Fact> facts_;  // beside the scene, sorted
  std::vector<FileContents::Entry> files_;
  scene::ContentsByName byName_;
  Digest digest_;
};

}  // namespace kinora::render
