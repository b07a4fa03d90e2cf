// Media that fill space: the objects of a scene whose material is a medium, and what tracking needs to know of them.
// Their boundaries are boxes, or have a hierarchy of their own, for no ray stops there. Made by render/space_media.h; read by the
// groups of all threads.
#pragma once
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "trace/world.h"
#include "volume/emission_cells.h"
#include "volume/majorants.h"
#include "volume/medium_field.h"

namespace kinora::shade {

struct SpaceMedium {
  uint32_t instance = 0, geometry = 0;  // in the world that rays see, where nothing sees it
  // trace::VisibilityBits, and a bit for each subset of rays that it is a member of: these rays know of it wherever they
  // meet it; others only inside interiors that are seen by them, where these and it have a name in common.
  uint32_t visibility = 15, visibilityInside = 0;
  std::vector<uint32_t> insideOf;  // names
  float side = 1;                  // -1: the normals of its boundary point inward
  bool mayEmit = false;
  // Extinction by render unit, where it is known without shading: factor, times fields of object space if any.
  bool isProduct = false;
  float factor[3] = {0, 0, 0};
  const volume::MediumField *number = nullptr, *color = nullptr;
  std::map<std::string, volume::MediumField, std::less<>> fields;  // what primvars of these names are
  // Velocity by object space and unit of the shutter's time: one field of three components, or one for each. Null: the
  // constant alone. Fields are those of time 0; places are carried along for as long as a point's time says.
  const volume::MediumField* velocity[3] = {nullptr, nullptr, nullptr};
  float velocityFactor = 1, constantVelocity[3] = {0, 0, 0};
  bool isCarried = false;
  float opens = 0, lasts = 0;     // when the shutter opens, counted from time 0 of the fields, and how long
  float low[3], high[3];          // of the object; beyond there is nothing that is carried
  float farthest[3] = {0, 0, 0};  // that anything is carried
  // Where it is at any time of the shutter.
  void findReach(float lowest[3], float highest[3]) const {
    for (int k = 0; k < 3; ++k) {
      lowest[k] = low[k] - farthest[k];
      highest[k] = high[k] + farthest[k];
    }
  }
  // See ExtinctionProduct.
  float extinctionByBounce = 1, contributionByBounce = 1;
  volume::Majorants majorants;  // by render unit, over object space
  // Coarser levels of the fields that extinction is a product of, from the second finest one on, with bounds of what is
  // looked up there. A ray sees a level where the radius of its footprint is the level's at least: its voxels are no
  // wider than the footprint. So which one follows from the ray and the distance along it.
  struct Level {
    float radius = 0;
    volume::Majorants majorants;
  };
  std::vector<Level> levels;
  float tint[3] = {1, 1, 1};   // channels of the extinction, about, over the means of its cells
  float towardsLights = 0.5f;  // see ExtinctionProduct
  // Cells that emit, and how much (4 pi times its volume integral, averaged over channels); null: none does.
  std::shared_ptr<const volume::EmissionCells> emission;
  float power = 0;
  std::string name;

  // The same everywhere in it, and all there is to know.
  bool isEven() const { return isProduct && !number && !color && !mayEmit; }
  // Of a product, at n points of object space and times of the shutter, 0 to 1, by kernels of that width. Arrays have
  // padded(n) elements; what comes out is the same bit for bit for any n and width.
  void productsAt(uint32_t width, uint32_t n, const float* const object[3], const float* time,
                  float* const extinction[3], uint32_t level = 0) const;
  // The distance along a ray from which on it sees the next level but `level`; infinity: there is none.
  float coarserFrom(uint32_t level, float radius, float spread) const {
    if (level >= levels.size()) return INFINITY;
    const float more = levels[level].radius - radius;
    return more <= 0 ? 0 : spread > 0 ? more / spread : INFINITY;
  }
  uint32_t levelAt(float t, float radius, float spread) const {
    uint32_t level = 0;
    while (t >= coarserFrom(level, radius, spread)) ++level;
    return level;
  }
  const volume::Majorants& boundsOf(uint32_t level) const { return level ? levels[level - 1].majorants : majorants; }
  // Where points of object space were when the fields were made. isInside 0: beyond them. Arrays as above.
  void carryBack(uint32_t width, uint32_t n, float* const object[3], const float* time, uint32_t* isInside) const;
  // Factor on its extinction for light that was scattered so often before.
  float similarity(uint32_t bounces) const;
};

// What is inside a surface that has media there, and cuts them off.
struct SpaceInterior {
  uint32_t visibility = 15;  // of the surface, as SpaceMedium::visibility: other rays never enter
  float side = 1;            // as SpaceMedium::side
  std::vector<uint32_t> names;
};

struct SpaceMedia {
  std::vector<SpaceMedium> media;
  std::vector<SpaceInterior> interiors;
  // Of SpaceMedium::insideOf and SpaceInterior::names. 0: there is no medium that some rays see inside of interiors only,
  // and no interior.
  uint32_t nameCount = 0;
  std::unordered_map<uint32_t, uint32_t> ofInstance;  // SpaceMedium::instance -> index
  // Of media whose boundaries are boxes that stand still, where these are few: their numbers. Those of the others and of
  // interiors are in a world, whose Instance::user is a number in `ofBoundary`; null: there are no others. Numbers of
  // interiors are those behind the media's.
  static constexpr uint32_t kMostBoxes = 8;
  std::vector<uint32_t> boxes, ofBoundary;
  std::shared_ptr<const trace::World> boundaries;
  bool mayEmit = false;
  bool areEven = false;           // all of them, see SpaceMedium::isEven()
  bool areShadowsOthers = false;  // some medium is known to shadow rays alone, or to the rays of paths alone
  bool hasSubsets = false;        // some object's rays do not know of all that others of their kind do
  bool isSimilar = false;         // some medium's extinction depends on how often light was scattered
  uint64_t serial = 0;            // each has its own, in a run of the program

  // Of what is bounded, by number.
  uint32_t visibilityOf(uint32_t number) const {
    if (number >= media.size()) return interiors[number - media.size()].visibility;
    return media[number].visibility | media[number].visibilityInside;
  }
  float sideOf(uint32_t number) const {
    return number < media.size() ? media[number].side : interiors[number - media.size()].side;
  }
};

// Makes an entry's hit the point of a medium at that distance.
void setMediumHit(const Hits& hits, uint32_t entry, const SpaceMedium& medium, float t);

// Where a ray crosses the boundary of a medium. While they are looked for: or of an interior.
struct MediumCrossing {
  uint32_t ray;
  float t;
  uint32_t medium;
  bool enters;
};

}  // namespace kinora::shade
