// Procedurals of a scene that are read when rays first meet their bounds (scene/procedural.h): which there are, which
// have been read, and the scene that is built of it. What was read stands in an object of its own, placed once, so that
// nothing that is made of the rest of the scene, or of another procedural, follows from it. Owned by Renderer; it knows
// no rays.
#pragma once
#include <ImathBox.h>

#include <atomic>
#include <memory>
#include <vector>

#include "base/diagnostics.h"
#include "base/file_contents.h"
#include "scene/procedural.h"

namespace kinora::render {

// What the builder of a world knows of them.
struct Delayed {
  struct Bound {
    Imath::Box3d box;  // in the world, over all keys of its transform
    scene::AttributesPtr attributes;
  };
  std::vector<Bound> all;      // of the description: what a world's extent is known by
  std::vector<Bound> unread;   // of the description and of what was read
  uint32_t firstInstance = 0;  // of the scene: from here on instances stand for what was read
};

class Procedurals {
 public:
  // Of another scene: nothing has been read.
  void setSources(std::shared_ptr<const scene::ProceduralSources> sources);
  // Of the scene as it is said now. What stands for the same request as before stays as it was.
  void begin(const scene::Scene& said);
  void forget();  // all that was read; begin() follows

  bool empty() const { return roots_.empty(); }
  // The scene to be built. The one of begin(), which must still be there, where it has no procedurals.
  const scene::Scene& scene() const { return empty() ? *said_ : scene_; }
  const Delayed& delayed() const { return delayed_; }
  // Reads those of delayed().unread, on all threads; messages come in the order of the list.
  void read(const std::vector<uint32_t>& which, FileContents& contents, Diagnostics& diagnostics,
            const std::atomic<bool>* stop);
  // Things are this much of a bound's size outside of it without a message: rays meet bounds that are larger by twice
  // as much.
  static constexpr double kRounded = 1e-4;
  // Of those that the last read() has read: places in the scene's list of instances, with what they stand for.
  struct Read {
    uint32_t instance;
    const scene::Primitive* procedural;
    Imath::Box3d bound;  // as it is said
  };
  const std::vector<Read>& lastRead() const { return lastRead_; }

  uint64_t total() const { return total_; }  // met so far, nested ones too
  uint64_t readCount() const { return readCount_; }

 private:
  struct Node {
    scene::PrimitivePtr primitive;
    std::shared_ptr<const scene::ProceduralSource> source;
    Imath::Box3d said, bound;  // in the world, as it is said and as rays meet it
    bool isRead = false, isNew = false;
    Imath::V3d middle{0, 0, 0};             // of the space of `whole`
    scene::Prototype whole;                 // what it holds, without nested ones
    std::vector<scene::Prototype> objects;  // that its instances place; they count from 0
    std::vector<std::unique_ptr<Node>> nested;
  };
  using Nodes = std::vector<std::unique_ptr<Node>>;
  static std::unique_ptr<Node> nodeOf(const scene::PrimitivePtr& primitive,
                                      std::shared_ptr<const scene::ProceduralSource> source);
  static void take(Node& node, scene::Expansion expansion, uint32_t firstId);
  void assemble();
  void add(Node& node);

  const scene::Scene* said_ = nullptr;
  std::shared_ptr<const scene::ProceduralSources> sources_;
  Nodes roots_;
  scene::Scene scene_;
  Delayed delayed_;
  std::vector<Node*> unread_;  // as delayed_.unread
  std::vector<Read> lastRead_;
  uint32_t nextId_ = 0;
  uint64_t total_ = 0, readCount_ = 0;
};

}  // namespace kinora::render
