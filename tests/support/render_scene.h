// A scene in, a film out: RIB text (or a file) rendered in this process, for tests of the whole renderer. Called by
// the programs of tests/bits, tests/truth and tests/images. It writes no displays and judges nothing: what a picture
// should be belongs to the test.
#pragma once
#include <kinora/testing/statistics.h>

#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "film/film.h"
#include "image/image.h"
#include "plugin/registry.h"
#include "render/renderer.h"

namespace kinora::tests {

// Every channel that the film can hold, for tests of equal bits.
extern const char* const kAllChannels;

struct RenderRequest {
  std::string rib;  // text; empty: `file` is read
  std::string file;
  std::string channels = "Ci,a";            // of the one display that replaces those of the scene
  render::Settings settings;                // threads 0 becomes 1
  std::function<void(scene::Scene&)> edit;  // before the world is built
};

class SceneRender {
 public:
  // Reads, builds and renders; failures are reported through GoogleTest and leave ok() false.
  explicit SceneRender(RenderRequest request);
  ~SceneRender();
  bool ok() const { return ok_; }
  film::Film& film() { return renderer_->film(); }
  render::Renderer& renderer() { return *renderer_; }
  const std::vector<std::string>& messages() const { return messages_; }  // warnings and errors
  const std::vector<std::string>& infos() const { return infos_; }
  // One channel of the film as floats, row by row.
  image::Image channel(const std::string& name);
  // Writes `picture` under the temporary folder and returns where; call it when a test fails.
  static std::string keep(const image::Image& picture, const std::string& name);

 private:
  std::vector<std::string> messages_, infos_;
  std::unique_ptr<Registry> registry_;
  std::unique_ptr<Diagnostics> diagnostics_;
  std::unique_ptr<render::Renderer> renderer_;
  bool ok_ = false;
};

// Whether some warning or error holds these words.
bool says(const SceneRender& render, const std::string& words);
// How many warnings and errors hold all of these words.
int64_t timesSaid(const SceneRender& render, std::initializer_list<std::string> words);

// A channel of a scene; a warning or error is a failure but where it holds one of the words that are expected.
image::Image pictureTold(const std::string& rib, std::initializer_list<std::string> expected,
                         const std::string& channel = "Ci");

// All integers of all pixels: two films are equal when these are.
std::vector<int64_t> stateOf(const film::Film& film);
// FNV-1a of them.
uint64_t hashOf(const film::Film& film);
// That of the request's picture, which has to be the same with any width, threads and groups.
uint64_t hashHoweverRendered(RenderRequest request);

// Mean of component c over all pixels. Pixels draw independent samples, so when all of them look at the same thing (a
// constant expectation) the spread between them gives the standard error of the mean.
testing::Moments overPixels(const image::Image& picture, int c = 0);

// Renders with `seeds` seeds; each render's mean over the frame (of component c of a channel) is one independent
// value.
testing::Moments overSeeds(RenderRequest request, int seeds, const std::string& channel = "Ci", int c = 0);

// |mean - expected| is within `tolerance` (absolute), and the standard error small enough to say so: at most a third
// of it. The failure names both.
#define EXPECT_MEAN(moments, expected, tolerance)                              \
  do {                                                                         \
    const auto& m_ = (moments);                                                \
    const double e_ = (expected), t_ = (tolerance);                            \
    EXPECT_NEAR(m_.mean(), e_, t_) << "standard error " << m_.standardError(); \
    EXPECT_LE(m_.standardError(), t_ / 3) << "too few samples to judge";       \
  } while (0)

// Two means agree: |difference| at most 4 standard errors (6e-5 by chance), and these at most `relativeError` of it.
#define EXPECT_SAME_MEAN(momentsA, momentsB, relativeError)                                                         \
  do {                                                                                                              \
    const auto& a_ = (momentsA);                                                                                    \
    const auto& b_ = (momentsB);                                                                                    \
    const double s_ = std::sqrt(a_.standardError() * a_.standardError() + b_.standardError() * b_.standardError()); \
    EXPECT_LE(std::abs(a_.mean() - b_.mean()), 4 * s_ + 1e-6 * std::abs(a_.mean()))                                 \
        << a_.mean() << " against " << b_.mean() << ", standard error " << s_;                                      \
    EXPECT_LE(s_, (relativeError)*std::abs(a_.mean())) << "too few samples to judge";                               \
  } while (0)

}  // namespace kinora::tests
