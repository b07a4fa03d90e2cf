#include "render/primitive_strings.h"

#include <algorithm>
#include <string_view>

namespace kinora::render {

namespace {

constexpr std::string_view kToken = "<primstr:";

// f(where a token begins, its length, the name in it) for each of a text, from its end on so that f may replace it.
template <class F>
void eachToken(const std::string& text, F&& f) {
  for (size_t at = text.rfind(kToken); at != std::string::npos;
       at = at ? text.rfind(kToken, at - 1) : std::string::npos) {
    const size_t end = text.find('>', at);
    if (end != std::string::npos) f(at, end + 1 - at, text.substr(at + kToken.size(), end - at - kToken.size()));
  }
}

template <class F>
void eachNode(const scene::Network& n, F&& f) {
  for (const scene::NodePtr& p : n.patterns) f(p);
  if (n.terminal) f(n.terminal);
}

std::string completed(std::string text, const std::vector<std::string>& names,
                      const std::vector<std::string>& words) {
  const std::string before = text;
  eachToken(before, [&](size_t at, size_t length, const std::string& name) {
    const auto k = std::find(names.begin(), names.end(), name) - names.begin();
    if (!words[size_t(k)].empty()) text.replace(at, length, words[size_t(k)]);
  });
  return text;
}

}  // namespace

const std::vector<std::string>& PrimitiveStrings::namesIn(const scene::NetworkPtr& network) {
  const auto [it, isNew] = names_.try_emplace(network);
  if (!isNew) return it->second;
  std::vector<std::string>& names = it->second;
  eachNode(*network, [&](const scene::NodePtr& n) {
    for (const scene::Parameter& p : n->params)
      for (const std::string& s : p.strings)
        eachToken(s, [&](size_t, size_t, const std::string& name) {
          if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
        });
  });
  return names;
}

scene::NetworkPtr PrimitiveStrings::completed(const scene::NetworkPtr& network, const scene::Primitive& primitive) {
  if (!network) return network;
  const std::vector<std::string>& names = namesIn(network);
  if (names.empty()) return network;
  std::vector<std::string> words;  // "": the primitive has none
  for (const std::string& name : names) {
    const scene::Parameter* p = primitive.primvars.find(name);
    const bool isThere = p && p->strings.size() == 1;
    words.push_back(isThere ? p->strings[0] : "");
    if (!isThere)
      diagnostics_.warning("PATTERN-PRIMSTR", primitive.pos,
                           "a file's name holds <primstr:" + name.substr(0, 60) + ">, and " + primitive.name() +
                               " has no constant string primvar of that name",
                           "the token stays in the name", "\"constant string " + name.substr(0, 60) + "\" [\"...\"]");
  }
  scene::NetworkPtr& made = made_[{network, words}];
  if (made) return made;
  const auto with = [&](const scene::NodePtr& n) -> scene::NodePtr {
    if (!n) return n;
    auto copy = std::make_shared<scene::Node>(*n);
    for (const scene::Parameter& p : n->params) {
      scene::Parameter changed = p;
      for (std::string& s : changed.strings) s = render::completed(s, names, words);
      copy->params.set(std::move(changed));
    }
    return copy;
  };
  auto copy = std::make_shared<scene::Network>();
  for (const scene::NodePtr& n : network->patterns) copy->patterns.push_back(with(n));
  copy->terminal = with(network->terminal);
  return made = std::move(copy);
}

}  // namespace kinora::render
