// What the entries of a sample record are filled from: by name of the channels' sources, resolved once a frame. Made by
// frame_plan.cpp, followed by each Worker.
#pragma once
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "film/film.h"
#include "film/light_paths.h"
#include "film/sources.h"

namespace kinora::render {

// What fills a record: for each entry where its values come from, resolved once a frame.
struct RecordPlan {
  // By record entry: the source behind it (the same for an entry whose values are remapped).
  std::vector<std::string> sources;
  std::vector<int> offsets, widths;
  std::vector<std::vector<int>> splatChannels;  // of the film, that take splats of this entry
  struct Surface {
    film::Source source;
    int offset, width;
    bool adds;
  };
  std::vector<Surface> surfaces;  // at camera hits
  struct Primvar {
    std::string name;
    int offset, width;
  };
  std::vector<Primvar> primvars;
  struct Constant {
    int offset;
    float value;
  };
  std::vector<Constant> cleared;  // what is not cleared to 0
  std::vector<int> coverage;      // floats that lights seen by the camera set to 1
  std::vector<int> cpuTime;
  struct Remap {
    int offset, width;
    std::array<float, 3> remap;
  };
  std::vector<Remap> remaps;  // before the film gets the record
  int floats = 0;
};
RecordPlan planRecord(const film::ChannelLayout& layout);
// Channels of reference positions and normals: where no object has a primvar of that name they show the one without the
// leading "__" (Pref, Nref, WPref, WNref).
bool isReferenceSource(std::string_view source);
// What the expressions say beyond paths: signals of user lobes (U2 albedo, U3 position, U6 normal) at the first
// surface.
void addUserLobes(const film::LightPaths& paths, RecordPlan& plan);

}  // namespace kinora::render
