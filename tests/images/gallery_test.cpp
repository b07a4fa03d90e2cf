// The gallery against small reference pictures, made by the program itself at 1,024 samples a pixel and looked at by
// eye. Proves that a change did not move brightness, colour, shape or place; misses anything that was wrong when they
// were made (tests/truth is for that) and detail finer than blocks of 8 x 8 pixels.
//
// New references: run test_images with KINORA_WRITE_REFERENCES=1, then look at them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "image/compare.h"
#include "image/read_write.h"
#include "support/render_scene.h"

namespace kinora::tests {
namespace {

struct Scene {
  const char* name;
  std::array<int, 2> resolution;
  // Root mean squared error of means over blocks of 8 x 8 pixels, as a share of the reference's mean; measured about
  // half of this at 64 samples.
  double blockError;
  double meanError;  // of the whole picture, relative
};
const Scene kScenes[] = {{"cornell", {128, 72}, 0.025, 0.01},   {"materials", {144, 60}, 0.035, 0.005},
                         {"field", {128, 72}, 0.04, 0.01},      {"grass", {128, 72}, 0.015, 0.005},
                         {"still_life", {128, 80}, 0.12, 0.01}, {"dragon", {128, 80}, 0.02, 0.005},
                         {"osl_wood", {128, 72}, 0.04, 0.01},   {"osl_brick", {128, 72}, 0.01, 0.005},
                         {"osl_rust", {128, 72}, 0.022, 0.005}, {"osl_weave", {128, 72}, 0.03, 0.005},
                         {"osl_paint", {128, 72}, 0.08, 0.015}, {"osl_sky", {128, 72}, 0.003, 0.003},
                         {"wax", {128, 72}, 0.15, 0.015},       {"fur", {128, 72}, 0.16, 0.01}};

class Gallery : public ::testing::TestWithParam<Scene> {};
INSTANTIATE_TEST_SUITE_P(Scenes, Gallery, ::testing::ValuesIn(kScenes),
                         [](const auto& info) { return std::string(info.param.name); });

image::Image blocks(const image::Image& a) {
  constexpr int kSide = 8;
  const int w = (a.width() + kSide - 1) / kSide, h = (a.height() + kSide - 1) / kSide;
  image::Image out({0, 0, w, h}, a.channels);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      for (int c = 0; c < a.channelCount(); ++c) {
        double sum = 0;
        int n = 0;
        for (int j = y * kSide; j < std::min((y + 1) * kSide, a.height()); ++j)
          for (int i = x * kSide; i < std::min((x + 1) * kSide, a.width()); ++i, ++n) sum += a.at(i, j)[c];
        out.at(x, y)[c] = float(sum / n);
      }
  return out;
}

TEST_P(Gallery, LooksAsItsReference) {
  const Scene& scene = GetParam();
  const bool writes = std::getenv("KINORA_WRITE_REFERENCES") != nullptr;
  const std::string file = std::string(KINORA_SOURCE_DIR "/tests/images/reference/") + scene.name + ".exr";
  RenderRequest r;
  r.file = std::string(KINORA_SOURCE_DIR "/scenes/") + scene.name + ".rib";
  r.settings.resolution = scene.resolution;
  r.settings.samplesPerPixel = writes ? 1024 : 64;
  r.settings.seed = writes ? 1 : 0;  // other samples than the reference's
  r.settings.threads = 2;
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  image::Image picture = render.channel("Ci");
  const char* const names[] = {"R", "G", "B"};
  for (size_t c = 0; c < 3; ++c) picture.channels[c] = {names[c], image::StoredType::Half};
  if (writes) {
    image::WriteOptions options;
    options.compression = image::Compression::Zip;
    const auto status = image::write(file, picture, options);
    ASSERT_TRUE(status.ok()) << status.what;
  }
  image::Image reference;
  const auto status = image::read(file, reference);
  ASSERT_TRUE(status.ok()) << status.what;
  image::Difference d;
  const auto compared = image::compare(blocks(picture), blocks(reference), {}, d);
  ASSERT_TRUE(compared.ok()) << compared.what;
  const double error = d.rmse / d.meanB, mean = d.meanA / d.meanB - 1;
  std::printf("%s: blocks differ by %.4f of the mean, the mean by %+.4f\n", scene.name, error, mean);
  if (error > scene.blockError || std::abs(mean) > scene.meanError) {
    image::Image difference;
    ASSERT_TRUE(image::differencePicture(picture, reference, 4, difference).ok());
    ADD_FAILURE() << "blocks differ by " << error << " of the mean (at most " << scene.blockError << "), the mean by "
                  << mean << " (at most " << scene.meanError << "); picture "
                  << SceneRender::keep(picture, std::string(scene.name) + "-picture") << ", reference "
                  << SceneRender::keep(reference, std::string(scene.name) + "-reference") << ", difference "
                  << SceneRender::keep(difference, std::string(scene.name) + "-difference");
  }
}

}  // namespace
}  // namespace kinora::tests
