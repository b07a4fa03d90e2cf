#include "support/render_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "image/read_write.h"
#include "rib/reader.h"

namespace kinora::tests {

const char* const kAllChannels =
    "Ci,a,z,P,Nn,Ngn,Vn,albedo,u,v,emissive,directDiffuse,indirectDiffuse,directSpecular,indirectSpecular,subsurface,"
    "transmissive";

SceneRender::SceneRender(RenderRequest request) {
  diagnostics_ = std::make_unique<Diagnostics>(
      [this](const std::string& line, Severity s) { (s != Severity::Info ? messages_ : infos_).push_back(line); });
  std::optional<scene::Scene> scene;
  rib::RibReader reader(*diagnostics_, {}, [&](scene::Scene&& s) { scene = std::move(s); });
  const bool read =
      request.rib.empty() ? reader.readFile(request.file) : reader.readString("test.rib", std::move(request.rib));
  reader.finish();
  if (!read || !scene) {
    ADD_FAILURE() << "no world in the scene: " << (messages_.empty() ? "" : messages_[0]);
    return;
  }
  scene::Display display;
  display.file = "test.exr";
  display.driver = "openexr";
  display.mode = request.channels;
  scene->displays = {display};
  if (request.edit) request.edit(*scene);
  if (request.settings.threads == 0) request.settings.threads = 1;
  if (!request.file.empty()) {
    const std::string folder = std::filesystem::path(request.file).parent_path().string();
    request.settings.texturePath.push_back(folder);
    request.settings.shaderPath.push_back(folder);
  }
  registry_ = std::make_unique<Registry>();
  renderer_ = std::make_unique<render::Renderer>(*registry_, *diagnostics_, request.settings);
  if (!renderer_->load(std::move(*scene))) {
    ADD_FAILURE() << "the scene cannot be rendered: " << (messages_.empty() ? "" : messages_[0]);
    return;
  }
  const render::Outcome outcome = renderer_->renderFilm();
  if (outcome != render::Outcome::Complete) {
    ADD_FAILURE() << "rendering ended with outcome " << int(outcome);
    return;
  }
  if (const uint64_t bad = renderer_->statistics().nonFiniteSamples) {
    ADD_FAILURE() << bad << " samples were not finite";
    return;
  }
  ok_ = true;
}

SceneRender::~SceneRender() = default;

image::Image SceneRender::channel(const std::string& name) {
  const int index = film().layout().find(name);
  if (index < 0) {
    ADD_FAILURE() << "the film has no channel " << name;
    return {};
  }
  return film().resolve(index);
}

std::string SceneRender::keep(const image::Image& picture, const std::string& name) {
  const auto folder = std::filesystem::temp_directory_path() / "kinora-failed";
  std::error_code ignored;
  std::filesystem::create_directories(folder, ignored);
  image::Image named = picture;
  const char* const names[] = {"R", "G", "B", "A"};
  for (size_t i = 0; i < named.channels.size() && i < 4; ++i)
    if (named.channels[i].name == std::to_string(i)) named.channels[i].name = names[i];
  const std::string file = (folder / (name + ".exr")).string();
  const auto status = image::write(file, named);
  return status.ok() ? file : status.what;
}

bool says(const SceneRender& render, const std::string& words) {
  return std::any_of(render.messages().begin(), render.messages().end(),
                     [&](const std::string& m) { return m.find(words) != std::string::npos; });
}

int64_t timesSaid(const SceneRender& render, std::initializer_list<std::string> words) {
  return std::count_if(render.messages().begin(), render.messages().end(), [&](const std::string& m) {
    return std::all_of(words.begin(), words.end(),
                       [&](const std::string& w) { return m.find(w) != std::string::npos; });
  });
}

image::Image pictureTold(const std::string& rib, std::initializer_list<std::string> expected,
                         const std::string& channel) {
  RenderRequest r;
  r.rib = rib;
  SceneRender render(std::move(r));
  EXPECT_TRUE(render.ok());
  if (!render.ok()) return {};
  for (const std::string& m : render.messages())
    if (std::none_of(expected.begin(), expected.end(),
                     [&](const std::string& words) { return m.find(words) != std::string::npos; }))
      ADD_FAILURE() << m;
  return render.channel(channel);
}

std::vector<int64_t> stateOf(const film::Film& film) {
  std::vector<int64_t> all;
  const auto& w = film.window();
  all.reserve(size_t(w.pixels()) * size_t(film.slots()));
  for (int y = w.y0; y < w.y1; ++y)
    for (int x = w.x0; x < w.x1; ++x) all.insert(all.end(), film.pixel(x, y), film.pixel(x, y) + film.slots());
  return all;
}

uint64_t hashOf(const film::Film& film) {
  uint64_t h = 1469598103934665603ull;
  for (const int64_t v : stateOf(film))
    for (int k = 0; k < 8; ++k) h = (h ^ (uint64_t(v) >> (8 * k) & 255)) * 1099511628211ull;
  return h;
}

uint64_t hashHoweverRendered(RenderRequest request) {
  std::vector<uint64_t> hashes;
  for (const auto& [width, threads, group] :
       {std::array{1u, 1u, 64u}, {4u, 2u, 512u}, {8u, 1u, 256u}, {16u, 2u, 1024u}}) {
    request.settings.width = width;
    request.settings.threads = int(threads);
    request.settings.groupSize = group;
    SceneRender r(request);
    if (!r.ok()) return 0;
    hashes.push_back(hashOf(r.film()));
  }
  for (const uint64_t h : hashes) EXPECT_EQ(h, hashes[0]);
  return hashes[0];
}

testing::Moments overPixels(const image::Image& picture, int c) {
  testing::Moments m;
  const size_t channels = picture.channels.size();
  for (size_t i = size_t(c); i < picture.pixels.size(); i += channels) m.add(picture.pixels[i]);
  return m;
}

testing::Moments overSeeds(RenderRequest request, int seeds, const std::string& channel, int c) {
  testing::Moments m;
  for (int s = 0; s < seeds; ++s) {
    request.settings.seed = uint32_t(s + 1);
    SceneRender r(request);
    if (!r.ok()) break;
    m.add(overPixels(r.channel(channel), c).mean());
  }
  return m;
}

}  // namespace kinora::tests
