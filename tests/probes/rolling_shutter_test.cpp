// Rolling shutters: lines of pixels that open one after the other. A wall whose edge crosses the picture lies, in each
// line, where it was then; and light paths, which come at all times, bring the same picture as camera paths, whatever
// the shutter's shape.
#include <string>

#include "tests/probes/methods.h"
#include "tests/probes/rooms.h"

namespace kinora::probes {
namespace {

std::string camera(const std::string& parameters) {
  return "Projection \"PxrCamera\" \"fov\" [90] " + parameters + "\n";
}
// The wall's left edge goes from the left side of the picture to the right one.
std::string crossing(const std::string& parameters, const std::string& before = "") {
  return R"(
Hider "raytrace" "int maxsamples" [64]
Display "probe.exr" "openexr" "Ci,a"
Format 32 32 1
PixelFilter "box" 1 1
Shutter 0 1
)" + before +
         camera(parameters) + R"(
WorldBegin
  Bxdf "PxrConstant" "wall" "color emitColor" [1 1 1]
  MotionBegin [0 1]
    Translate -1 0 0
    Translate 1 0 0
  MotionEnd
  Polygon "vertex point P" [0 -4 1 0 4 1 9 4 1 9 -4 1]
WorldEnd
)";
}

// The edge of a pixel's line, in its width of 1, that is open from start to start + duration.
TEST(RollingShutter, EachLineHasItsTime) {
  for (const double duration : {0.0, 0.25, 0.6, 1.0})
    for (const char* sweep : {"down", "up", "right", "left"}) {
      Workshop stage;
      render::Settings s;
      s.threads = 2;
      const auto r = stage.load(sceneOf(crossing("\"float duration\" [" + std::to_string(duration) +
                                                 "] \"string sweep\" [\"" + std::string(sweep) + "\"]"),
                                        stage.messages),
                                s);
      const image::Image picture = pictureOf(*r);
      for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) {
          const std::string to = sweep;
          const double line = ((to == "down" || to == "up" ? y : x) + 0.5) / 32;
          const double start = (1 - duration) * (to == "up" || to == "left" ? 1 - line : line);
          // the mean over the pixel's width and its time of being right of the edge, which lies at the time
          double expected = 0;
          constexpr int kSteps = 64;
          for (int i = 0; i < kSteps; ++i) {
            const double edge = 32 * (start + duration * (i + 0.5) / kSteps);
            expected += std::min(1.0, std::max(0.0, x + 1 - edge)) / kSteps;
          }
          ASSERT_NEAR(picture.at(x, y)[0], expected, 0.08) << sweep << " " << duration << " " << x << " " << y;
        }
    }
}

// A room in motion, by paths from both ends as by camera paths alone.
TEST(RollingShutter, LightPathsAgree) {
  Workshop stage;
  for (const std::string& shape :
       {std::string(), std::string("Camera \"c\" \"float[8] shutteropening\" [0.1 0.3 0.2 0.6 0.5 0.9 0.7 0.1]\n")}) {
    std::string text = roomInMotionThroughALens();
    const std::string plain = "Projection \"perspective\" \"fov\" [40]";
    const size_t at = text.find(plain);
    ASSERT_NE(at, std::string::npos);
    text.replace(at, plain.size(),
                 "Projection \"PxrCamera\" \"fov\" [40] \"float duration\" [0.3] \"string sweep\" [\"right\"]");
    const size_t lens = text.find(kLens);
    text.replace(lens, std::string(kLens).size(), "");
    if (!shape.empty()) text.insert(text.find("Projection"), shape);
    const Pictures paths = renderAll(stage, text, pathTracer(), 100, 16);
    expectEqual(renderAll(stage, text, vcm(true, false), 300, 16), paths, "connected" + shape, 0.1);
  }
}

TEST(RollingShutter, SameBits) {
  std::string text = roomInMotionThroughALens();
  const std::string plain = "Projection \"perspective\" \"fov\" [40]";
  text.replace(text.find(plain), plain.size(), "Projection \"PxrCamera\" \"fov\" [40] \"float duration\" [0.3]");
  for (const char* integrator : {"PxrPathTracer", "PxrVCM"}) expectSameBits({}, text, integrator);
}

}  // namespace
}  // namespace kinora::probes
