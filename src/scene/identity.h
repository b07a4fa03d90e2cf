// Whether two scenes are the same picture, and if not, what is the first thing in which they differ. Everything that
// decides a pixel counts, by the lists of scene/fields.h: no name of a file's place, no pointer, no id. Called by
// render/ for the hash of a frame and for parts of one, by film/ when parts are merged.
#pragma once
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/digest.h"
#include "scene/scene.h"

namespace kinora::scene {

// What the files hold that parameters name: such a string counts as that, and not as a path of one machine.
using ContentsByName = std::unordered_map<std::string, Digest>;

// The digests of primitives, remembered with them from one digest of a scene to the next: geometry is most of what
// there is to read. What is shared is const, so that an edit puts another one in its place.
struct PrimitiveDigests {
  struct Known {
    PrimitivePtr primitive;
    Digest digest;
  };
  // As they count beside these other things: files by content, light sources by place.
  Digest surroundings;
  std::unordered_map<const Primitive*, Known> known;
};

// Whether a parameter of the Hider decides what a sample is; which of a frame's samples are taken, `sampleoffset` and
// `samplestride`, is written beside the digest: parts of one frame differ in them.
bool hiderDecidesPixels(const Parameter& parameter);
inline bool isHider(const Node& n) { return n.kind == "Hider"; }

Digest digestOf(const Scene& scene, const ContentsByName& files = {}, PrimitiveDigests* remembered = nullptr);

// The things that a scene is made of with digests of their fields: enough to name a difference without the scene. Its
// size is bounded: of very many things of a kind several share an entry.
struct Inventory {
  struct Part {
    std::string name;  // `sides`, `primvar "st"`
    uint32_t digest = 0;
    bool operator==(const Part&) const = default;
  };
  struct Thing {
    std::string name;   // `object "ball"`, `option "limits:gridsize"`
    std::string place;  // "scene.rib:12", "" when it has none
    uint32_t count = 1;
    std::string last;  // of several: the name of the last one
    uint64_t digest = 0;
    std::vector<Part> parts;  // "" where there are too many
    bool operator==(const Thing&) const = default;
  };
  std::vector<Thing> things;
  void add(const std::string& name, const Digest& digest) { things.push_back({name, "", 1, "", digest.low, {}}); }
};

struct InventorySize {
  size_t entries = 2048;  // for things of one kind
  size_t parts = 8192;    // for their fields
};
Inventory inventoryOf(const Scene& scene, const ContentsByName& files = {}, const InventorySize& most = {});

// `object "ball" (scene.rib:12) differs in sides`; "" when they are the same. A thing that only one of them has is
// "in the first only" or "in the second only", by the names given.
std::string firstDifference(const Inventory& first, const Inventory& second,
                            std::string_view nameOfFirst = "the first", std::string_view nameOfSecond = "the second");

// The plug-ins and shaders that the scene names, as written.
std::set<std::string> pluginsOf(const Scene& scene);

}  // namespace kinora::scene
