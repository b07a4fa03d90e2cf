// Light split by the events of its path sums to the beauty channel: each contribution lands in exactly one of the
// seven standard channels. Over all gallery scenes and all stock integrators of camera paths, at a small size. It
// misses whether a contribution is in the *right* channel; that each has some light somewhere is all it asks.
#include <algorithm>
#include <array>
#include <filesystem>
#include <map>

#include "tests/probes/probe_support.h"

namespace kinora::probes {
namespace {

constexpr std::array<const char*, 8> kParts{"emissive",         "directDiffuse", "indirectDiffuse", "directSpecular",
                                            "indirectSpecular", "subsurface",    "transmissive",    "volume"};

TEST(Lobes, SplitSumsToBeauty) {
  Workshop stage;
  const std::filesystem::path folder = std::filesystem::path(__FILE__).parent_path() / "../../scenes";
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".rib") files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  ASSERT_GE(files.size(), 3u);
  std::map<std::string, double> seen;
  for (const std::string& file : files)
    for (const char* integrator : {"PxrPathTracer", "PxrDirectLighting"}) {
      scene::Scene scene = sceneOfFile(file, stage.messages);
      scene.displays.clear();
      scene::Display display;
      display.file = "probe.exr";
      display.driver = "openexr";
      display.mode = "Ci";
      for (const char* part : kParts) {
        display.mode += std::string(",") + part;
        scene::DisplayChannel channel;
        channel.name = part;
        scene.channels.push_back(channel);
      }
      scene.displays.push_back(display);
      render::Settings s;
      s.resolution = {64, 36};
      s.samplesPerPixel = 4;
      s.integrator = integrator;
      s.texturePath = {folder.string()};
      const auto r = stage.load(std::move(scene), s);
      const image::Image beauty = pictureOf(*r);
      std::vector<image::Image> parts;
      for (const char* part : kParts) parts.push_back(r->film().resolve(r->film().layout().find(part)));
      double total = 0, worst = 0;
      for (int y = 0; y < 36; ++y)
        for (int x = 0; x < 64; ++x)
          for (int k = 0; k < 3; ++k) {
            double sum = 0;
            for (size_t p = 0; p < parts.size(); ++p) {
              sum += parts[p].at(x, y)[k];
              seen[kParts[p]] += parts[p].at(x, y)[k];
            }
            const double b = beauty.at(x, y)[k];
            total += b;
            worst = std::max(worst, std::fabs(sum - b) / std::max(1e-3, std::fabs(b)));
          }
      EXPECT_LT(worst, 1e-5) << file << " " << integrator;
      EXPECT_GT(total, 1.0) << file << " " << integrator << "\n" << stage.said;
    }
  for (const char* part : kParts) EXPECT_GT(seen[part], 0.1) << part;
}

}  // namespace
}  // namespace kinora::probes
