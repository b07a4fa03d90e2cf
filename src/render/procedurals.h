// Procedurals of a scene that are read when rays first meet their bounds (scene/procedural.h): which there are, which
// are held, and the scene that is built of it. What was read stands in an object of its own, placed once, so that
// nothing that is made of the rest of the scene, or of another procedural, follows from it: it can be dropped, and be
// read again. Owned by Renderer; it knows no rays.
#pragma once
#include <ImathBox.h>

#include <atomic>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "base/file_contents.h"
#include "render/reading_plan.h"
#include "scene/procedural.h"

namespace kinora::render {

// What the builder of a world knows of them.
struct Delayed {
  struct Bound {
    Imath::Box3d box;  // in the world, over all keys of its transform
    scene::AttributesPtr attributes;
    // Of one that has been held: boxes that hold all that is in it. Rays that meet none of them meet nothing of it.
    // Null: its box does.
    std::shared_ptr<const std::vector<Imath::Box3d>> cells = nullptr;
  };
  std::vector<Bound> all;      // of the description: what a world's extent is known by
  std::vector<Bound> unread;   // of the description and of what was read
  uint32_t firstInstance = 0;  // of the scene: from here on instances stand for what was read
};

class Procedurals {
 public:
  // Of another scene: nothing has been read.
  void setSources(std::shared_ptr<const scene::ProceduralSources> sources);
  // Of the scene as it is said now. Nothing is held, as in a scene that has just been read: what a frame is known by
  // must not follow from what rays met before.
  void begin(const scene::Scene& said);
  // What was held before begin(), stands for the same request and has files that are as they were is held again. False:
  // there is nothing of that kind.
  bool resume(FileContents& contents);

  bool empty() const { return roots_.empty(); }
  // The scene to be built. The one of begin(), which must still be there, where it has no procedurals.
  const scene::Scene& scene() const { return empty() ? *said_ : scene_; }
  const Delayed& delayed() const { return delayed_; }
  // Procedurals are known by numbers, which they keep while they stand for the same request.
  const std::vector<HeldProcedural>& all() const { return held_; }
  uint32_t numberOfUnread(uint32_t place) const { return unread_[place]->number; }  // of delayed().unread
  // Sizes of what has not been read are expected; exact sizes of what is held are told by setBytes().
  void expectSizes(const std::vector<uint32_t>& which);
  void setBytes(uint32_t number, uint64_t bytes);  // of its meshes and hierarchies: the description is known here
  bool hasCells(uint32_t number) const { return nodes_[number]->cells != nullptr; }
  void setCells(uint32_t number, std::vector<Imath::Box3d> cells);  // see Delayed::Bound
  void setNeeded(uint32_t number, uint64_t when) { held_[number].lastNeeded = when; }

  // Reads what is not held, on all threads; messages come in the order of the list. What stands in others that are not
  // held is left out.
  void read(const std::vector<uint32_t>& which, FileContents& contents, Diagnostics& diagnostics,
            const std::atomic<bool>* stop);
  // Nothing of these is held any more. What stands in them is not held, or comes before them in the list.
  void drop(const std::vector<uint32_t>& which);
  void countAsGone() { leaving_ = 0; }  // there is a world that does not hold it
  // Things are this much of a bound's size outside of it without a message: rays meet bounds that are larger by twice
  // as much.
  static constexpr double kRounded = 1e-4;
  // Of those that have been read since settle(): places in the scene's list of instances, with what they stand for.
  struct Read {
    uint32_t instance, number;
    const scene::Primitive* procedural;
    Imath::Box3d bound;  // as it is said
    bool isAgain;        // it was read before
  };
  const std::vector<Read>& lastRead() const { return lastRead_; }
  void settle();

  struct Counts {
    uint64_t met = 0;                           // so far, nested ones too
    uint64_t read = 0, again = 0, dropped = 0;  // `read` counts each once
    uint64_t bytes = 0, mostBytes = 0, largest = 0;
  };
  const Counts& counts() const { return counts_; }

 private:
  using Contents = std::vector<std::pair<std::string, Digest>>;
  struct Node {
    uint32_t number = HeldProcedural::kNone;
    scene::PrimitivePtr primitive;
    std::shared_ptr<const scene::ProceduralSource> source;  // null: what said it is not held, or says it no more
    Imath::Box3d said, bound;                               // in the world, as it is said and as rays meet it
    std::shared_ptr<const std::vector<Imath::Box3d>> cells;
    bool isNew = false, wasRead = false;
    bool isAside = false;                                    // it is not held, but still there
    Contents contents;                                       // that it was made of when it was read last
    std::vector<std::pair<std::string, std::string>> files;  // as scene::Expansion has them
    std::vector<int64_t> stamps;                             // of these, when they were read
    uint32_t firstId = 0;
    uint64_t ids = 0, descriptionBytes = 0;
    uint64_t fileBytes = 0;                 // expected to be read; 0: nobody has asked, or it is not known
    Imath::V3d middle{0, 0, 0};             // of the space of `whole`
    scene::Prototype whole;                 // what it holds, without nested ones
    std::vector<scene::Prototype> objects;  // that its instances place; they count from 0
    std::vector<std::unique_ptr<Node>> nested;
  };
  using Nodes = std::vector<std::unique_ptr<Node>>;
  bool isHeld(const Node& n) const { return held_[n.number].isHeld; }
  static bool describe(Node& node, const scene::PrimitivePtr& primitive,
                       std::shared_ptr<const scene::ProceduralSource> source);
  void enter(Node& node, uint32_t inside);  // gives it its number
  void leave(Node& node);                   // it and what is in it are gone
  void release(Node& node);                 // what it holds, and what is in it
  void setAside(Node& node);                // until resume()
  static void take(Node& node, scene::Expansion expansion, uint32_t firstId);
  void tellOfChange(const Node& node, const Contents& now, Diagnostics& diagnostics);
  void countBytes();
  void assemble();
  void add(Node& node);

  const scene::Scene* said_ = nullptr;
  std::shared_ptr<const scene::ProceduralSources> sources_;
  Nodes roots_;
  scene::Scene scene_;
  Delayed delayed_;
  std::vector<Node*> unread_;  // as delayed_.unread
  std::vector<Node*> nodes_;   // by number; null: gone
  std::vector<HeldProcedural> held_;
  std::vector<Read> lastRead_;
  std::set<std::string> told_;  // files that have changed
  uint32_t nextId_ = 0;
  uint64_t leaving_ = 0;  // dropped, while the world before may hold it
  Counts counts_;
};

}  // namespace kinora::render
