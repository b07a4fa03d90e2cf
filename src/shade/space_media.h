// Media that fill space: the objects of a scene whose material is a medium, and what tracking needs to know of them.
// Their boundaries have a hierarchy of their own, for no ray stops there. Made by render/space_media.h; read by the
// groups of all threads.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "trace/world.h"
#include "volume/majorants.h"
#include "volume/medium_field.h"

namespace kinora::shade {

struct SpaceMedium {
  uint32_t instance = 0, geometry = 0;  // in the world that rays see, where nothing sees it
  uint32_t visibility = 15;             // trace::VisibilityBits: rays of other kinds do not know of it
  float side = 1;                       // -1: the normals of its boundary point inward
  bool mayEmit = false;
  // Extinction by render unit, where it is known without shading: factor, times fields of object space if any.
  bool isProduct = false;
  float factor[3] = {0, 0, 0};
  const volume::MediumField *number = nullptr, *color = nullptr;
  std::map<std::string, volume::MediumField, std::less<>> fields;  // what primvars of these names are
  volume::Majorants majorants;                                     // by render unit, over object space
  std::string name;

  // The same everywhere in it, and all there is to know.
  bool isEven() const { return isProduct && !number && !color && !mayEmit; }
  // Of a product, at a point of object space.
  void productAt(const float object[3], float extinction[3]) const;
};

struct SpaceMedia {
  std::vector<SpaceMedium> media;
  std::unordered_map<uint32_t, uint32_t> ofInstance;  // SpaceMedium::instance -> index
  std::shared_ptr<const trace::World> boundaries;     // Instance::user: index
  bool mayEmit = false;
};

// Makes an entry's hit the point of a medium at that distance.
void setMediumHit(const Hits& hits, uint32_t entry, const SpaceMedium& medium, float t);

// Where a ray crosses the boundary of a medium.
struct MediumCrossing {
  uint32_t ray;
  float t;
  uint32_t medium;
  bool enters;
};

}  // namespace kinora::shade
