// The lights of a world: plug-in instances with their filters and geometry, which objects they light, and the trees
// over them. A light's own data are kept from one world to the next, and the trees as long as no light, no link and
// nothing of the world's extent is another. Called by WorldBuilder.
#pragma once
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/file_contents.h"
#include "film/light_paths.h"
#include "light/light_set.h"
#include "render/camera.h"
#include "render/flat_scene.h"
#include "render/legacy_lights.h"
#include "render/light_shadows.h"
#include "render/light_surfaces.h"
#include "render/statistics.h"

namespace kinora::render {

// Names in a list of groups (grouping:membership, subsets), apart by white space or commas; a "+" that stands alone
// is none.
std::vector<std::string> groupNames(const std::string& list);

// What is said of an object about lights: lighting:subset and excludesubset, lightfilter:subset, handles that are off,
// and the ids of LightSources that are not on its list.
struct Linking {
  std::string subset, exclude, filters;
  std::vector<std::string> off;
  std::vector<uint32_t> unlisted;
  auto operator<=>(const Linking&) const = default;
};
// Objects of the same lights share a set; set 0 is that of all lights.
using LinkSets = std::map<Linking, uint32_t>;
// Sets `linkSet` of each of `infos`.
LinkSets linkObjects(const scene::Scene& scene, const LightsToRender& sources, const FlatScene& flat,
                     std::vector<shade::PlacementInfo>& infos);

class Lights {
 public:
  struct Tools {
    Registry& registry;
    Diagnostics& diagnostics;
    FileContents& contents;
    const std::vector<std::string>& searchPath;  // of textures
    const Host& host;
    const CameraState& camera;
    const film::LightPaths& paths;
    const ShadowSets& shadowSets;
    const LightSurfaces::ByLight& surfaces;  // of `sources`
    bool areShadowsOthers = false;           // shadow rays and rays that find lights do not see the same objects
  };
  // Of the world that `world` holds by now; sets what it says of link sets. `sources`, `flat` as above.
  std::shared_ptr<const light::LightSet> make(const scene::Scene& scene, const LightsToRender& sources,
                                              const LinkSets& links, const FlatScene& flat, const Tools& tools,
                                              shade::ShadingWorld& world, Rebuilt& made);
  void forget() { *this = {}; }

 private:
  // What a plug-in made of one light.
  struct Made {
    light::LightEntry entry;  // but for its kind
    LightMark mark{};         // of a light that only marks
    FileContents::Names files;
    uint64_t serial = 0;
  };
  struct Chosen;  // the lights of this world
  // `dome`: that a portal shows, else null.
  std::shared_ptr<const Made> madeOf(const scene::Light& light, const scene::Light* dome, const Descriptor& plugin,
                                     const scene::Scene& scene, const Tools& tools, Rebuilt& made);
  Chosen choose(const scene::Scene& scene, const LightsToRender& sources, const Tools& tools, Rebuilt& made);

  std::map<Digest, std::shared_ptr<const Made>> before_, now_;
  uint64_t lastSerial_ = 0;
  Digest ofSet_;
  std::shared_ptr<const light::LightSet> set_;
};

}  // namespace kinora::render
