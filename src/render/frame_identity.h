// What makes two renders the same frame: all that the scene says (scene/identity.h), what the files hold that it
// reads (textures, shaders, volumes, light maps, colour configuration), the plug-ins' libraries and the version of
// the program; not the seed, the samples, or how and where it is rendered. Made by Renderer when the world is built,
// in a thread of its own: files take time to read that the first pixels need not wait for. Its hash goes into every
// picture, the inventory into parts of a frame.
#pragma once
#include <future>
#include <string>
#include <vector>

#include "base/digest.h"
#include "base/file_contents.h"
#include "plugin/registry.h"
#include "scene/identity.h"

namespace kinora::render {

class FrameIdentity {
 public:
  // Of a world that was just built. The scene must stay as it is until wait() or any of the others has returned.
  // isEdited: it is that of the world before, edited; digests of its primitives are remembered for the next time.
  void start(const scene::Scene& scene, FileContents& contents, const Registry& registry, bool isEdited);
  void wait() const;
  // 32 digits. Early pictures do without: "" when it is not ready and they may not wait.
  std::string hash(bool mayWait);
  // For parts of the frame: what the hash was made of. The scene is that of start().
  scene::Inventory inventory(const scene::Scene& scene);
  // Files that were first asked for while it was rendered: shaders make names as they go. Which ones depends on the
  // samples, so that the hash cannot know them.
  std::vector<FileContents::Entry> lateFiles(FileContents& contents);

 private:
  struct Fact {
    std::string kind, name;
    Digest content;
    auto operator<=>(const Fact&) const = default;
  };
  void make(const scene::Scene& scene, FileContents& contents, bool isEdited);
  void finish();  // as wait(), but throws what stopped it: memory that is not there

  std::vector<Fact> facts_;                 // beside the scene, sorted
  std::vector<FileContents::Entry> files_;  // known before the first sample
  scene::ContentsByName byName_;
  scene::PrimitiveDigests primitives_;  // of the world before
  Digest digest_;
  std::future<void> made_;  // the last member: it is waited for first
};

}  // namespace kinora::render
