// Procedurals that are read when somebody asks for them: a primitive of the description ("Procedural" with a bound)
// stands for what its archive or program would say, and a source knows how to read it. Written by rib/, asked by
// render/ once a ray meets the bound. A source holds the graphics state of its request, so that what it gives does not
// depend on when it is asked.
#pragma once
#include <ImathBox.h>

#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "base/digest.h"
#include "scene/scene.h"

namespace kinora::scene {

class ProceduralSource;
using ProceduralSources = std::unordered_map<uint32_t, std::shared_ptr<const ProceduralSource>>;  // by primitive's id

// What stands in a procedural, in the world's space. Ids, and places of objects and solids, are its own.
struct Expansion {
  std::vector<PrimitivePtr> primitives;
  InstanceList instances;
  std::vector<Prototype> prototypes;
  std::vector<Solid> solids;
  ProceduralSources nested;                                // of those of its primitives that are procedurals in turn
  std::vector<std::pair<std::string, std::string>> files;  // read for it: by name, and the path
  // What it was made of: by path or command, what the file held or the program printed.
  std::vector<std::pair<std::string, Digest>> contents;
};

class ProceduralSource {
 public:
  virtual ~ProceduralSource() = default;
  // With the transform and the attributes of `as`, which is the primitive that stands for it. From any thread, more
  // than once. What cannot be read is a message, and nothing. `isAgain`: it was read before, and counts among what a
  // frame may read already.
  virtual Expansion expand(const Primitive& as, Diagnostics& diagnostics, bool isAgain) const = 0;
  // Size of what it reads, as far as that can be known before; 0: it cannot.
  virtual uint64_t bytesToRead() const { return 0; }
};

// The bound of a procedural as its request says it, in its own space; nothing where there is none, or no finite one.
std::optional<Imath::Box3d> boundOf(const Primitive& procedural);

}  // namespace kinora::scene
