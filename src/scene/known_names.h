// Names of options that scenes are known to give. The interpreter tells by them what is misspelt in a scene, and --set
// what is no option at all.
#pragma once
#include <algorithm>
#include <string_view>

namespace kinora::scene {

// Names in their group; "$": a string.
struct KnownNames {
  std::string_view group, names;
};
inline constexpr KnownNames kKnownOptions[] = {
    {"bucket", "$order orderorigin"},
    {"checkpoint", "$interval $exitat $command keepfiles asfinal"},
    {"limits",
     "bucketsize gridsize shadesize threads texturememory textureperthreadmemoryratio geocachememory "
     "opacitycachememory ptexturememory ptexturemaxfiles brickmemory octreememory pointmemory matrixcachememory "
     "rendermemory rendertime othreshold zthreshold deepshadowerror nurbcurvaturedicefactor"},
    {"trace", "bvhcompression $worldorigin worldoffset maxdepth decimationrate"},
    {"lighting", "minimumestimate selectionlearningscheme"},
    {"curve", "minwidth"},
    {"shade",
     "roughnessmollification shadowBumpTerminator debug subsurfaceTypeDefaultFromVersion24 "
     "chiangCompatibilityVersion"},
    {"shutter", "offset"},
    {"lpe",
     "$diffuse1 $diffuse2 $diffuse3 $diffuse4 $diffuse5 $diffuse6 $diffuse7 $diffuse8 $specular1 $specular2 "
     "$specular3 $specular4 $specular5 $specular6 $specular7 $specular8 $user1 $user2 $user3 $user4 $user5 $user6 "
     "$user7 $user8 $user9 $user10 $user11 $user12"},
    {"searchpath", "$shader $texture $archive $procedural $display $rixplugin $resource $servershader $dirmap"},
    {"statistics", "$filename $xmlfilename $jsonFilename"},
    {"Ri",
     "Clipping CropWindow FormatPixelAspectRatio FormatResolution Frame FrameAspectRatio $PixelFilterName "
     "PixelFilterWidth PixelVariance ScreenWindow Shutter"},
};
// Scenes seldom give these, and names too near one another to tell slips by.
inline constexpr KnownNames kMoreOptions[] = {
    {"detail", "relative"},
    {"shader", "cache"},
};

// f(name, whether it is a string) for each; true ends it.
template <class F>
bool eachName(std::string_view names, F&& f) {
  for (size_t at = 0; at < names.size();) {
    const size_t end = std::min(names.find(' ', at), names.size());
    const std::string_view one = names.substr(at, end - at);
    const bool isString = one[0] == '$';
    if (f(one.substr(isString ? 1 : 0), isString)) return true;
    at = end + 1;
  }
  return false;
}

}  // namespace kinora::scene
