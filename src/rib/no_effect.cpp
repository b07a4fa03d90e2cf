#include "rib/no_effect.h"

#include <algorithm>

#include "rib/condition.h"

namespace kinora::rib {

namespace {

// `usual`: values, parted by '|', that ask for nothing else than what is done. Names that files carry by the hundred and
// whose values only trade time or memory are not here.
struct Entry {
  Where where;
  std::string_view name, usual;
  const char* why;
};
constexpr Entry kEntries[] = {
    {Where::Hider, "adaptall", "0", "the first colour channel decides how many samples a pixel takes"},
    {Where::Hider, "exposurebracket", "-1 1",
     "adaptive sampling weighs noise by the level around, with \"darkfalloff\" alone"},
    {Where::Hider, "minextrasamples", "-1|0", "decisions of adaptive sampling are taken at fixed counts of samples"},
    {Where::Option, "checkpoint:asfinal", "0", "snapshots go through the display drivers as final pictures do"},
    {Where::Option, "lighting:minimumestimate", "1e-06",
     "no light is skipped: lights are chosen by how much they bring, and weighed by that"},
    {Where::Option, "shade:subsurfaceTypeDefaultFromVersion24", "0",
     "materials that say no subsurfaceType have the path traced one, 5"},
    {Where::Option, "shade:shadowBumpTerminator", "1", "materials say it themselves, by a parameter of that name"},
    {Where::Option, "shade:roughnessmollification", "0|1", "roughness stays what it is along a path"},
    {Where::Option, "trace:maxdepth", "10", "integrators say how long paths are: \"maxIndirectBounces\" and its kin"},
    {Where::Attribute, "trace:autobias", "1",
     "rays begin where rounding ends by themselves, and \"trace:bias\" is not asked for"},
    {Where::Attribute, "dice:strategy", "planarprojection|instanceprojection|sphericalprojection",
     "\"micropolygonlength\" is in pixels of the camera, whatever the strategy"},
    {Where::Attribute, "dice:worlddistancelength", "-1", "\"micropolygonlength\" says how finely surfaces are cut"},
    {Where::Attribute, "volume:fps", "1|24", "velocities of volumes are in units of the shutter's times"},
    {Where::Attribute, "volume:shutteroffset", "0|1", "velocities of volumes count from the times of the shutter"},
    {Where::Attribute, "volume:velocityshuttercorrection", "0", "velocities of volumes are taken as they are"},
    {Where::Attribute, "volume:voxelinterpolation", "0|2", "voxels are interpolated linearly"},
    {Where::Attribute, "trace:samplemotion", "1",
     "an object in motion is blurred: Hider \"int samplemotion\" [0] shows the whole frame without blur"},
    {Where::Display, "resolution", "", "pictures have the size that Format or --res says"},
    {Where::Display, "origin", "0 0", "pictures begin at the corner of the frame"},
    {Where::Display, "merge", "0", "the file is written anew: `kinora merge` adds parts of a frame"},
};

}  // namespace

const char* whyNoEffect(Where where, std::string_view name, const scene::Parameter& p) {
  for (const Entry& e : kEntries) {
    if (e.where != where || e.name != name) continue;
    const std::string value = plainText(p);
    for (std::string_view rest = e.usual;;) {
      const size_t end = std::min(rest.find('|'), rest.size());
      if (value == rest.substr(0, end)) return nullptr;
      if (end == rest.size()) return e.why;
      rest.remove_prefix(end + 1);
    }
  }
  return nullptr;
}

const char* otherHider(std::string_view name) {
  if (name == "bake") return "no textures are baked: a picture of the camera's is rendered";
  if (name == "photon") return "no photon map is made: a picture of the camera's is rendered";
  // those of other renderers and times that make one of the camera's
  for (const std::string_view picture :
       {"", "raytrace", "hidden", "stochastic", "stitch", "null", "zbuffer", "opengl"})
    if (name == picture) return nullptr;
  return "a picture of the camera's is rendered, as \"raytrace\" does";
}

}  // namespace kinora::rib
