#include "render/statistics.h"

namespace kinora::render {

const char* nameOf(StageTime s) {
  static const char* const kNames[] = {
      "camera rays",           "trace camera", "trace indirect",       "trace shadow", "grouping",
      "networks and closures", "lights",       "integrator and bxdfs", "film"};
  return s < StageTime::Count ? kNames[size_t(s)] : "?";
}

}  // namespace kinora::render
