// Sample filters, display filters, light filters and pixel filters in whole renders: each acts at its place (on
// samples before they are averaged; on pixels, leaving the film alone; on light samples and light hits alike), at
// every width with the same bits, and each mistake in a scene is one message. Values are closed forms; the filters'
// own arithmetic is tested beside them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "image/read_write.h"
#include "support/render_scene.h"

namespace kinora::tests {
namespace {

// A glowing ball of radiance 5 over nothing; its edge pixels are mixtures.
std::string ball(const std::string& filters) {
  return "Format 32 32 1\nProjection \"orthographic\"\nHider \"raytrace\" \"int maxsamples\" [16]\n"
         "Integrator \"PxrPathTracer\" \"i\"\nPixelFilter \"box\" 1 1\n" +
         filters +
         "WorldBegin\nTranslate 0 0 5\nAttributeBegin\n"
         "Bxdf \"PxrConstant\" \"glow\" \"color emitColor\" [5 5 5]\nSphere 0.7 -0.7 0.7 "
         "360\nAttributeEnd\nWorldEnd\n";
}

RenderRequest request(std::string rib) {
  RenderRequest r;
  r.rib = std::move(rib);
  return r;
}

TEST(SampleFilter, WorksOnSamplesBeforeTheyAreAveraged) {
  SceneRender r(request(ball("SampleFilter \"PxrGradeSampleFilter\" \"g\" \"int clampWhite\" [1]\n")));
  ASSERT_TRUE(r.ok());
  const image::Image c = r.channel("Ci"), a = r.channel("a");
  int mixed = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      // each sample is 0 or 1 after the clamp, so a pixel is its coverage; clamped pixels would be 1 on the edge
      EXPECT_NEAR(c.at(x, y)[0], a.at(x, y)[0], 1e-5);
      mixed += a.at(x, y)[0] > 0.1f && a.at(x, y)[0] < 0.9f;
    }
  EXPECT_GT(mixed, 10);
}

TEST(SampleFilter, LastIsActiveAndACombinerRunsItsOwnInOrder) {
  const std::string half = "SampleFilter \"PxrGradeSampleFilter\" \"half\" \"color gain\" [0.5 0.5 0.5]\n",
                    plus = "SampleFilter \"PxrGradeSampleFilter\" \"plus\" \"color offset\" [1 1 1]\n";
  const auto middle = [](const std::string& filters) {
    SceneRender r(request(ball(filters)));
    return r.ok() ? r.channel("Ci").at(16, 16)[0] : -1.f;
  };
  EXPECT_NEAR(middle(half + plus), 6, 1e-5);
  EXPECT_NEAR(middle(plus + half), 2.5, 1e-5);
  const std::string combine =
      "SampleFilter \"PxrSampleFilterCombiner\" \"both\" \"reference samplefilter[2] filter\" ";
  EXPECT_NEAR(middle(half + plus + combine + "[\"half\" \"plus\"]\n"), 3.5, 1e-5);
  EXPECT_NEAR(middle(half + plus + combine + "[\"plus\" \"half\"]\n"), 3, 1e-5);
  // combiners of combiners, and one that comes to itself again
  const std::string outer = "SampleFilter \"PxrSampleFilterCombiner\" \"all\" \"reference samplefilter[2] filter\" ";
  EXPECT_NEAR(middle(half + plus + combine + "[\"half\" \"plus\"]\n" + outer + "[\"both\" \"half\"]\n"), 1.75, 1e-5);
  SceneRender circle(request(ball(half + combine + "[\"half\" \"all\"]\n" + outer + "[\"both\" \"half\"]\n")));
  ASSERT_TRUE(circle.ok());
  EXPECT_TRUE(says(circle, "FILTER-REFERENCE"));
  EXPECT_NEAR(circle.channel("Ci").at(16, 16)[0], 1.25, 1e-5);
}

// Channels of one source: those that no filter names stay as they are, and so does the beauty.
TEST(SampleFilter, ChangesTheChannelsThatItNamesAlone) {
  const std::string channels =
      "DisplayChannel \"color Ci\"\nDisplayChannel \"float a\"\nDisplayChannel \"color graded\" \"string source\" "
      "[\"Ci\"]\n"
      "DisplayChannel \"color plain\" \"string source\" [\"Ci\"]\n"
      "DisplayChannel \"color K\" \"string source\" [\"lpe:C.*O\"]\nDisplayChannel \"color K2\" \"string source\" "
      "[\"lpe:C.*O\"]\n";
  for (const std::string named : {"graded", "K2", "Ci", "plain"}) {
    RenderRequest wanted = request(
        ball(channels + "SampleFilter \"PxrGradeSampleFilter\" \"g\" \"color gain\" [2 2 2] \"string aov\" [\"" +
             named + "\"]\n"));
    wanted.channels = "Ci,a,graded,plain,K,K2";
    SceneRender r(wanted);
    ASSERT_TRUE(r.ok());
    for (const std::string channel : {"Ci", "graded", "plain", "K", "K2"})
      EXPECT_NEAR(r.channel(channel).at(16, 16)[0], channel == named ? 10 : 5, 1e-4)
          << channel << ", filtered: " << named;
  }
}

TEST(SampleFilter, LightOfLightPathsIsTold) {
  RenderRequest r = request(ball("SampleFilter \"PxrGradeSampleFilter\" \"g\" \"color gain\" [2 2 2]\n"));
  const auto told = [&] {
    SceneRender render(r);
    const auto m = render.messages();
    return std::count_if(m.begin(), m.end(),
                         [](const std::string& x) { return x.find("FILTER-SPLATS") != std::string::npos; });
  };
  EXPECT_EQ(told(), 0);
  r.rib.replace(r.rib.find("PxrPathTracer"), 13, "PxrVCM");
  EXPECT_EQ(told(), 1);
}

TEST(SampleFilter, SameBitsAtAllWidthsThreadsAndGroups) {
  const std::string rib =
      ball("SampleFilter \"PxrGradeSampleFilter\" \"g\" \"color gamma\" [1.7 0.9 2.2] \"color mask\" [0.5 1 0.2]\n");
  const uint64_t hash = hashHoweverRendered(request(rib));
  SceneRender plain(request(ball("")));
  EXPECT_NE(hashOf(plain.film()), hash) << "the filter does nothing";
}

TEST(DisplayFilter, ChangesPicturesAndLeavesTheFilm) {
  const std::string file =
      (std::filesystem::temp_directory_path() / ("kinora_filters_" + std::to_string(getpid()) + ".exr")).string();
  RenderRequest q =
      request(ball("DisplayFilter \"PxrBackgroundDisplayFilter\" \"back\" \"color backgroundColor\" [0.25 0.5 1]\n"));
  q.settings.output = file;
  SceneRender r(q);
  ASSERT_TRUE(r.ok());
  EXPECT_EQ(r.channel("Ci").at(0, 0)[2], 0.f);
  ASSERT_EQ(r.renderer().render(), render::Outcome::Complete);
  image::Image picture;
  ASSERT_TRUE(image::read(file, picture).ok());
  std::filesystem::remove(file);
  ASSERT_GE(picture.channelCount(), 4);
  const image::Image film = r.channel("Ci"), alpha = r.channel("a");
  const float back[3] = {0.25f, 0.5f, 1};
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(picture.at(x, y)[c], film.at(x, y)[c] + (1 - alpha.at(x, y)[0]) * back[c], 3e-3)  // half floats
            << x << " " << y;
}

// The background imager of old files left pixels that count as covered.
TEST(DisplayFilter, BackgroundCanCoverAll) {
  const std::string file =
      (std::filesystem::temp_directory_path() / ("kinora_covered_" + std::to_string(getpid()) + ".exr")).string();
  RenderRequest q = request(ball("Imager \"background\" \"color bgcolor\" [0.25 0.5 1]\n"));
  q.settings.output = file;
  SceneRender r(q);
  ASSERT_TRUE(r.ok());
  ASSERT_EQ(r.renderer().render(), render::Outcome::Complete);
  image::Image picture;
  ASSERT_TRUE(image::read(file, picture).ok());
  std::filesystem::remove(file);
  ASSERT_GE(picture.channelCount(), 4);
  EXPECT_NEAR(picture.at(0, 0)[2], 1, 1e-3);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) EXPECT_NEAR(picture.at(x, y)[3], 1, 2e-3) << x << " " << y;
}

// The picture that a render writes.
image::Image written(const std::string& filters, int threads = 1, uint32_t width = 16,
                     std::vector<std::string>* said = nullptr) {
  const std::string file =
      (std::filesystem::temp_directory_path() / ("kinora_written_" + std::to_string(getpid()) + ".exr")).string();
  RenderRequest q = request(ball(filters));
  q.settings.output = file;
  q.settings.threads = threads;
  q.settings.width = width;
  SceneRender r(q);
  image::Image picture;
  EXPECT_TRUE(r.ok());
  EXPECT_EQ(r.renderer().render(), render::Outcome::Complete);
  EXPECT_TRUE(image::read(file, picture).ok());
  if (said) *said = r.messages();
  std::filesystem::remove(file);
  return picture;
}

// Neighbours are those before the filter, for any threads and width: the edges of a disk are its rim on both sides.
TEST(DisplayFilter, MaySeeOtherPixels) {
  const std::string edges = "DisplayFilter \"PxrEdgeDetect\" \"e\"\n";
  const image::Image plain = written(""), one = written(edges, 1, 16), four = written(edges, 3, 4);
  EXPECT_EQ(one.pixels, four.pixels);
  const auto at = [&](int x, int y) { return plain.at(std::clamp(x, 0, 31), std::clamp(y, 0, 31))[0]; };
  int rim = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      float g[2] = {0, 0};
      for (int k = -1; k < 2; ++k) {
        const float weight = k ? 0.125f : 0.25f;
        g[0] += weight * (at(x + 1, y + k) - at(x - 1, y + k));
        g[1] += weight * (at(x + k, y + 1) - at(x + k, y - 1));
      }
      EXPECT_NEAR(one.at(x, y)[0], std::hypot(g[0], g[1]), 0.01) << x << " " << y;  // half floats
      rim += one.at(x, y)[0] > 0.5f;
    }
  EXPECT_GT(rim, 60);
}

// A display with settings of its own has channels of its own, and whatever a filter does to the first it does to it.
TEST(Filters, ReachDisplaysWithSettingsOfTheirOwn) {
  const auto folder = std::filesystem::temp_directory_path() / ("displays_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const auto second = [&](const std::string& filters, const std::string& name, std::vector<float> numbers) {
    RenderRequest q = request(ball(filters));
    q.settings.output = (folder / "first.exr").string();
    q.edit = [&](scene::Scene& s) {
      scene::Display d = s.displays[0];
      d.file = (folder / "second.exr").string();
      scene::Parameter p;
      p.name = name;
      p.type = scene::ValueType::Float;
      p.isArray = true;
      p.arrayLength = int(numbers.size());
      p.floats = numbers;
      d.params.set(p);
      s.displays.push_back(d);
    };
    SceneRender r(q);
    image::Image picture;
    EXPECT_TRUE(r.ok());
    if (!r.ok()) return picture;
    EXPECT_GE(r.film().layout().find("Ci'"), 0);
    EXPECT_EQ(r.renderer().render(), render::Outcome::Complete);
    EXPECT_TRUE(image::read((folder / "second.exr").string(), picture).ok());
    EXPECT_GE(picture.channelCount(), 4);
    return picture;
  };
  const std::string back = "BackgroundDisplayFilter\" \"b\" \"color backgroundColor\" [0.25 0.5 1]\n",
                    samples = "BackgroundSampleFilter\" \"b\" \"color backgroundColor\" [0.25 0.5 1]\n";
  for (const bool isWide : {true, false})
    for (const std::string& filter : {"DisplayFilter \"Pxr" + back, "SampleFilter \"Pxr" + samples}) {
      const std::string name = isWide ? "filterwidth" : "remap";
      const std::vector<float> numbers = isWide ? std::vector<float>{3, 3} : std::vector<float>{2, 3, 8};
      const image::Image out = second(filter, name, numbers), plain = second("", name, numbers);
      if (out.channelCount() < 4 || plain.channelCount() < 4) continue;
      EXPECT_NEAR(out.at(0, 0)[0], 0.25f, 2e-3) << filter << name;
      EXPECT_NEAR(out.at(0, 0)[2], 1, 2e-3) << filter << name;
      // the alpha beside it is that of the same display
      for (int x = 0; x < 32 && isWide; ++x)
        EXPECT_NEAR(out.at(x, 16)[2], plain.at(x, 16)[2] + 1 - plain.at(x, 16)[3], 6e-3) << filter << x;
    }
  // coverage too
  const image::Image covered = second("Imager \"background\" \"color bgcolor\" [0.25 0.5 1]\n", "remap", {2, 3, 8});
  if (covered.channelCount() >= 4) {
    EXPECT_NEAR(covered.at(0, 0)[2], 1, 2e-3);
    EXPECT_NEAR(covered.at(0, 0)[3], 1, 2e-3);
  }
  std::filesystem::remove_all(folder);
}

TEST(DisplayFilter, APictureBehind) {
  const auto folder = std::filesystem::temp_directory_path() / ("plates_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  image::Image plate({0, 0, 32, 32}, {{"R"}, {"G"}, {"B"}});
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      plate.at(x, y)[0] = float(x) / 32;
      plate.at(x, y)[1] = float(y) / 32;
      plate.at(x, y)[2] = 0.5f;
    }
  ASSERT_TRUE(image::write((folder / "plate.exr").string(), plate).ok());
  const std::string path = "Option \"searchpath\" \"string texture\" [\"" + folder.string() + "\"]\n";
  const image::Image plain = written("");
  for (const char* filter :
       {"DisplayFilter \"PxrImageDisplayFilter\" \"p\"", "SampleFilter \"PxrImagePlaneFilter\" \"p\""}) {
    std::vector<std::string> said;
    const image::Image out = written(path + filter + " \"string filename\" [\"plate.exr\"]\n", 1, 16, &said);
    EXPECT_EQ(said.size(), 1u) << "that there is no light: " << said.back();
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x)
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(out.at(x, y)[c], plain.at(x, y)[c] + (1 - plain.at(x, y)[3]) * plate.at(x, y)[c], 4e-3)
              << filter << " " << x << " " << y;
    const image::Image missing = written(path + filter + " \"string filename\" [\"gone.exr\"]\n", 1, 16, &said);
    EXPECT_EQ(missing.pixels, plain.pixels) << "nothing is behind";
    ASSERT_EQ(said.size(), 2u);
    EXPECT_NE((said[0] + said[1]).find("gone.exr"), std::string::npos) << said[0] << said[1];
  }
  std::filesystem::remove_all(folder);
}

// PNG holds colours without their alpha; the sky that the camera sees is no part of what stands before it.
TEST(Displays, EdgesBeforeTheSkyAreNoBrighterThanWhatCovers) {
  const std::string file =
      (std::filesystem::temp_directory_path() / ("kinora_edges_" + std::to_string(getpid()) + ".png")).string();
  RenderRequest q = request(ball(""));
  q.rib.replace(q.rib.find("[5 5 5]"), 7, "[0.1 0.2 0.05]");
  q.rib.insert(q.rib.find("Translate 0 0 5"), "Light \"PxrDomeLight\" \"sky\" \"color lightColor\" [0.5 0.6 0.8]\n");
  q.settings.output = file;
  SceneRender r(q);
  ASSERT_TRUE(r.ok());
  const image::Image alpha = r.channel("a");
  ASSERT_EQ(r.renderer().render(), render::Outcome::Complete);
  image::Image picture;
  ASSERT_TRUE(image::read(file, picture).ok());
  std::filesystem::remove(file);
  const float ballColor[3] = {0.1f, 0.2f, 0.05f}, sky[3] = {0.5f, 0.6f, 0.8f};
  int edges = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      const float a = alpha.at(x, y)[0];
      edges += a > 0 && a < 1;
      EXPECT_NEAR(picture.at(x, y)[3], a, 0.5 / 255 + 1e-4);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(picture.at(x, y)[c] * 255, image::encodeSrgb8((a > 0 ? ballColor : sky)[c]), 1) << x << " " << y;
    }
  EXPECT_GT(edges, 30);
}

// A floor under a rectangle that the camera sees too; the path tracer finds the light by both halves.
std::string room(const std::string& filter) {
  return "Format 24 24 1\nProjection \"perspective\" \"fov\" [60]\nHider \"raytrace\" \"int maxsamples\" [8]\n"
         "Integrator \"PxrPathTracer\" \"i\" \"int maxIndirectBounces\" [3]\nTranslate 0 -0.5 4\nWorldBegin\n"
         "AttributeBegin\nTransformBegin\nTranslate 0 2 0\nRotate 90 1 0 0\nCoordinateSystem \"above\"\n" +
         filter +
         "Light \"PxrRectLight\" \"key\" \"float intensity\" [8]\nTransformEnd\nAttributeEnd\n"
         "AttributeBegin\nBxdf \"PxrDiffuse\" \"grey\" \"color diffuseColor\" [0.5 0.5 0.5]\n"
         "Polygon \"P\" [-3 0 -3  3 0 -3  3 0 3  -3 0 3]\nAttributeEnd\nWorldEnd\n";
}

TEST(LightFilter, OneFactorEverywhereIsAnotherIntensity) {
  SceneRender plain(request(room(""))),
      filtered(request(room("LightFilter \"PxrIntMultLightFilter\" \"f\" \"float exposure\" [-2]\n")));
  ASSERT_TRUE(plain.ok() && filtered.ok());
  const image::Image a = plain.channel("Ci"), b = filtered.channel("Ci");
  double sum = 0, most = 0;
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 24; ++x)
      for (int c = 0; c < 3; ++c) {
        // the same paths; a quarter of each, light samples, light met by rays and the light as it is seen alike
        EXPECT_NEAR(b.at(x, y)[c], 0.25f * a.at(x, y)[c], 1e-6f * (1 + a.at(x, y)[c]));
        sum += a.at(x, y)[c];
        most = std::max(most, double(a.at(x, y)[c]));
      }
  EXPECT_GT(sum, 10);
  EXPECT_GT(most, 4) << "the light itself is not seen";
}

double meanOf(const image::Image& picture) {
  double sum = 0;
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 24; ++x) sum += picture.at(x, y)[0];
  return sum / (24 * 24);
}

TEST(LightFilter, CombineByTheirModesOrACombiners) {
  const auto filter = [](const char* name, const char* more) {
    return std::string("LightFilter \"PxrIntMultLightFilter\" ") + name + " " + more + "\n";
  };
  const auto mean = [](const std::string& filters) {
    SceneRender r(request(room(filters)));
    EXPECT_TRUE(r.ok());
    EXPECT_FALSE(says(r, "FILTER-REFERENCE"));
    return meanOf(r.channel("Ci"));
  };
  const std::string a = filter("\"a\"", "\"float intensity\" [0.25]"),
                    b = filter("\"b\"", "\"float intensity\" [0.5]"), c = filter("\"c\"", "\"float intensity\" [3]");
  const double plain = mean("");
  const std::pair<const char*, double> modes[] = {{"mult", 0.125}, {"max", 0.5}, {"min", 0.25}, {"screen", 0.625}};
  for (const auto& [mode, factor] : modes) {
    const std::string combiner =
        std::string("LightFilter \"PxrCombinerLightFilter\" \"all\" \"reference lightfilter[2] ") + mode +
        "\" [\"a\" \"b\"]\n";
    EXPECT_NEAR(mean(a + b + c + combiner) / plain, 3 * factor, 1e-5) << mode << " by a combiner; c multiplies";
    const std::string own = std::string("\"string combineMode\" [\"") + mode + "\"]";
    EXPECT_NEAR(mean(filter("\"a\"", ("\"float intensity\" [0.25] " + own).c_str()) + c +
                     filter("\"b\"", ("\"float intensity\" [0.5] " + own).c_str())) /
                    plain,
                3 * factor, 1e-5)
        << mode << " by their own";
  }
  EXPECT_NEAR(mean(a + b + c +
                   "LightFilter \"PxrCombinerLightFilter\" \"all\" \"reference lightfilter[2] max\" [\"a\" \"b\"] "
                   "\"reference lightfilter[1] min\" [\"c\"]\n") /
                  plain,
              1.5, 1e-5)
      << "groups multiply";
  SceneRender gone(
      request(room("LightFilter \"PxrCombinerLightFilter\" \"all\" \"reference lightfilter[1] max\" [\"x\"]\n")));
  EXPECT_TRUE(says(gone, "FILTER-REFERENCE"));
  EXPECT_NEAR(meanOf(gone.channel("Ci")) / plain, 1, 1e-5);
}

// The same light by its samples alone nearly, by rays that meet it alone, and by both.
TEST(LightFilter, SamplesAndHitsSeeOneFactor) {
  const char* filters[] = {
      "\"PxrBarnLightFilter\" \"f\" \"float width\" [0.5] \"float edge\" [0.3]",
      "\"PxrRodLightFilter\" \"f\" \"string coordsys\" [\"low\"] \"float edge\" [1]",
      "\"PxrBlockerLightFilter\" \"f\" \"string coordsys\" [\"low\"] \"float edge\" [1]",
      "\"PxrRampLightFilter\" \"f\" \"float endDist\" [4]",
      "\"PxrCookieLightFilter\" \"f\" \"string map\" [\"TEXTURE\"] \"float width\" [2] \"color fillColor\" [0 0 0]",
      "\"PxrGoboLightFilter\" \"f\" \"string map\" [\"TEXTURE\"] \"float width\" [2] \"color fillColor\" [0 0 0]",
  };
  const std::string texture =
      (std::filesystem::temp_directory_path() / ("filter_map_" + std::to_string(getpid()) + ".exr")).string();
  image::Image map({0, 0, 2, 1}, {{"R"}, {"G"}, {"B"}});
  for (int c = 0; c < 3; ++c) {
    map.at(0, 0)[c] = 1;
    map.at(1, 0)[c] = 0.25f;
  }
  ASSERT_TRUE(image::write(texture, map).ok());
  const auto mean = [&](std::string filter, int lightSamples, int bxdfSamples) {
    if (const size_t at = filter.find("TEXTURE"); at != std::string::npos) filter.replace(at, 7, texture);
    std::string rib = room("LightFilter " + filter + "\n");
    const std::string from = "Integrator \"PxrPathTracer\" \"i\" \"int maxIndirectBounces\" [3]";
    rib.replace(rib.find(from), from.size(),
                "Integrator \"PxrDirectLighting\" \"i\" \"int numLightSamples\" [" + std::to_string(lightSamples) +
                    "] \"int numBxdfSamples\" [" + std::to_string(bxdfSamples) + "]");
    rib.replace(rib.find("[8]"), 3, "[64]");
    rib.insert(rib.find("AttributeBegin"),
               "TransformBegin Translate 0.5 0 0 CoordinateSystem \"low\" TransformEnd\n");
    SceneRender r(request(rib));
    EXPECT_TRUE(r.ok());
    EXPECT_FALSE(says(r, "LIGHT-FILTER-SPACE"));
    return meanOf(r.channel("Ci"));
  };
  const double plain = mean("\"PxrIntMultLightFilter\" \"f\"", 4, 4);
  for (const char* f : filters) {
    const double hits = mean(f, 0, 16), both = mean(f, 4, 4), samples = mean(f, 32, 1);
    EXPECT_NEAR(hits / both, 1, 0.02) << f;
    EXPECT_NEAR(samples / both, 1, 0.01) << f;
    EXPECT_LT(both, 0.95 * plain) << f << ": does nothing";
    EXPECT_GT(both, 0.02 * plain) << f << ": all dark";
  }
  std::filesystem::remove(texture);
}

TEST(LightFilter, AProfileIsReadFromItsFile) {
  const auto folder = std::filesystem::temp_directory_path() / ("profiles_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const auto put = [&](const char* name, const std::string& text) { std::ofstream(folder / name) << text; };
  put("spot.ies", "IESNA91\n[TEST] 1\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 50\n0 30 60\n0\n800 400 0\n");
  put("broken.ies", "IESNA91\n[TEST] 1\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 50\n0 60 30\n0\n800 400 0\n");
  const auto render = [&](const std::string& filter, const std::string& file) {
    std::string rib = room(filter);
    const std::string light = "\"float intensity\" [8]";
    if (!file.empty()) rib.insert(rib.find(light), "\"string iesProfile\" [\"" + file + "\"] ");
    rib = "Option \"searchpath\" \"string texture\" [\"" + folder.string() + "\"]\n" + rib;
    return SceneRender(request(rib));
  };
  SceneRender plain = render("", ""), spot = render("", "spot.ies"), missing = render("", "no.ies"),
              broken = render("", "broken.ies"),
              tables = render(
                  "LightFilter \"IesLightFilter\" \"f\" \"float[3] verticalAngles\" [0 30 60] "
                  "\"float[3] candela\" [8 4 0]\n",
                  "");
  EXPECT_TRUE(spot.messages().empty()) << spot.messages()[0];
  EXPECT_EQ(hashOf(spot.film()), hashOf(tables.film()));
  EXPECT_NE(hashOf(spot.film()), hashOf(plain.film()));
  EXPECT_EQ(hashOf(missing.film()), hashOf(plain.film()));
  EXPECT_TRUE(says(missing, "ASSET-IES-MISSING"));
  EXPECT_EQ(hashOf(broken.film()), hashOf(plain.film()));
  ASSERT_EQ(broken.messages().size(), 1u);
  EXPECT_NE(broken.messages()[0].find("broken.ies:6: warning ASSET-IES-READ"), std::string::npos)
      << broken.messages()[0];
  std::filesystem::remove_all(folder);
}

TEST(PixelFilter, APluginsFilterIsTheFrames) {
  std::string rib = ball("");
  rib.replace(rib.find("PixelFilter \"box\" 1 1"), 21, "PixelFilter \"hann\" 3 3");
  SceneRender r(request(rib));
  ASSERT_TRUE(r.ok());
  EXPECT_FALSE(says(r, "FILM-FILTER"));
  SceneRender box(request(ball("")));
  EXPECT_NE(hashOf(r.film()), hashOf(box.film()));
  EXPECT_NEAR(r.channel("Ci").at(16, 16)[0], 5, 1e-4) << "a constant stays one";
}

TEST(Filters, MistakesAreOneMessageEach) {
  const auto expect = [](const std::string& filters, const char* code) {
    SceneRender r(request(ball(filters)));
    EXPECT_TRUE(r.ok());
    EXPECT_TRUE(says(r, code)) << code;
    SceneRender plain(request(ball("")));
    EXPECT_EQ(hashOf(r.film()), hashOf(plain.film())) << code << ": the fallback is the picture without it";
  };
  expect("SampleFilter \"PxrNoSuchFilter\" \"f\"\n", "PLUGIN-MISSING");
  expect("DisplayFilter \"PxrNoSuchFilter\" \"f\"\n", "PLUGIN-MISSING");
  expect("SampleFilter \"PxrGradeSampleFilter\" \"f\" \"string aov\" [\"nowhere\"]\n", "FILTER-CHANNEL");
  expect("SampleFilter \"PxrGradeSampleFilter\" \"f\" \"color whitePoint\" [0 0 0]\n", "PLUGIN-CREATE");
  expect("SampleFilter \"PxrSampleFilterCombiner\" \"f\" \"reference samplefilter[1] filter\" [\"gone\"]\n",
         "FILTER-REFERENCE");
  SceneRender space(request(room("LightFilter \"PxrIntMultLightFilter\" \"f\" \"string coordsys\" [\"gone\"]\n")));
  EXPECT_TRUE(says(space, "LIGHT-FILTER-SPACE"));
  SceneRender missing(request(room("LightFilter \"PxrNoSuchLightFilter\" \"f\"\n"))), plain(request(room("")));
  EXPECT_TRUE(says(missing, "PLUGIN-MISSING"));
  EXPECT_EQ(hashOf(missing.film()), hashOf(plain.film()));
  std::string rib = ball("");
  rib.replace(rib.find("PixelFilter \"box\" 1 1"), 21, "PixelFilter \"hann\" -3 0");
  SceneRender negative(request(rib));
  EXPECT_TRUE(negative.ok());
  EXPECT_TRUE(says(negative, "RIB-ARGUMENTS"));
}

}  // namespace
}  // namespace kinora::tests
