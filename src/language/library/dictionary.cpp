#include "language/library/dictionary.h"

#include <map>
#include <mutex>
#include <pugixml.hpp>
#include <vector>

#include "language/library/text.h"

namespace kinora::language {

struct Dictionary::Impl {
  struct Node {
    pugi::xml_node node;
    int next = 0;
  };
  std::function<void(const std::string&)> report;
  std::mutex mutex;
  std::map<std::string, std::unique_ptr<pugi::xml_document>, std::less<>> documents;  // null: not valid
  std::vector<Node> nodes{Node{}};                                                    // [0] is no node
  std::map<std::pair<int, std::string>, int> below;                                   // answers of earlier queries
  std::map<std::pair<const pugi::xml_document*, std::string>, int> inDocument;

  pugi::xml_document* open(std::string_view name) {
    if (const auto it = documents.find(name); it != documents.end()) return it->second.get();
    auto document = std::make_unique<pugi::xml_document>();
    const bool file = endswith(name, ".xml");
    const pugi::xml_parse_result r =
        file ? document->load_file(std::string(name).c_str()) : document->load_buffer(name.data(), name.size());
    if (!r) {
      if (report)
        report("dictionary " + (file ? "\"" + std::string(name) + "\"" : std::string("text")) + ": " +
               r.description() + " at character " + std::to_string(r.offset));
      document.reset();
    }
    return documents.emplace(std::string(name), std::move(document)).first->second.get();
  }
  int query(const pugi::xml_node& from, const std::string& path) {
    int first = 0;
    try {
      const pugi::xpath_node_set found = from.select_nodes(path.c_str());
      for (const pugi::xpath_node& n : found) {
        if (!n.node()) continue;
        nodes.push_back({n.node(), 0});
        const int id = int(nodes.size()) - 1;
        if (first)
          nodes[size_t(id) - 1].next = id;
        else
          first = id;
      }
    } catch (const pugi::xpath_exception& e) {
      if (report) report("dictionary query \"" + path + "\": " + e.what());
    }
    return first;
  }
  bool text(int id, std::string_view attribute, std::string& result) {
    if (id <= 0 || size_t(id) >= nodes.size()) return false;
    const pugi::xml_node& n = nodes[size_t(id)].node;
    if (attribute.empty()) {
      result = n.value()[0] ? n.value() : n.child_value();
      return true;
    }
    const pugi::xml_attribute a = n.attribute(std::string(attribute).c_str());
    if (a) result = a.value();
    return bool(a);
  }
};

Dictionary::Dictionary(std::function<void(const std::string&)> report) : impl_(std::make_unique<Impl>()) {
  impl_->report = std::move(report);
}
Dictionary::~Dictionary() = default;

int Dictionary::find(std::string_view textOrFile, std::string_view query) {
  const std::lock_guard lock(impl_->mutex);
  const pugi::xml_document* document = impl_->open(textOrFile);
  if (!document) return -1;
  const auto [it, isNew] = impl_->inDocument.try_emplace({document, std::string(query)}, 0);
  if (isNew) it->second = impl_->query(*document, it->first.second);
  return it->second;
}
int Dictionary::find(int node, std::string_view query) {
  const std::lock_guard lock(impl_->mutex);
  if (node <= 0 || size_t(node) >= impl_->nodes.size()) return 0;
  const auto [it, isNew] = impl_->below.try_emplace({node, std::string(query)}, 0);
  if (isNew) it->second = impl_->query(pugi::xml_node(impl_->nodes[size_t(node)].node), it->first.second);
  return it->second;
}
int Dictionary::next(int node) {
  const std::lock_guard lock(impl_->mutex);
  return node > 0 && size_t(node) < impl_->nodes.size() ? impl_->nodes[size_t(node)].next : 0;
}
bool Dictionary::value(int node, std::string_view attribute, std::string& result) {
  const std::lock_guard lock(impl_->mutex);
  return impl_->text(node, attribute, result);
}
namespace {
// `count` numbers apart by blanks and commas.
bool numbers(std::string_view s, int count, const std::function<void(int, std::string_view)>& take) {
  std::vector<std::string_view> words;
  for (size_t i = 0; i < s.size();) {
    const size_t begin = s.find_first_not_of(" \t\r\n,", i);
    if (begin == std::string_view::npos) break;
    i = std::min(s.find_first_of(" \t\r\n,", begin), s.size());
    words.push_back(s.substr(begin, i - begin));
  }
  if (int(words.size()) < count) return false;
  for (int i = 0; i < count; ++i)
    if (words[size_t(i)].find_first_of("0123456789") == std::string_view::npos) return false;
  for (int i = 0; i < count; ++i) take(i, words[size_t(i)]);
  return true;
}
}  // namespace
bool Dictionary::value(int node, std::string_view attribute, int32_t* result, int count) {
  std::string text;
  return value(node, attribute, text) &&
         numbers(text, count, [&](int i, std::string_view w) { result[i] = stoi(w); });
}
bool Dictionary::value(int node, std::string_view attribute, float* result, int count) {
  std::string text;
  return value(node, attribute, text) &&
         numbers(text, count, [&](int i, std::string_view w) { result[i] = stof(w); });
}

}  // namespace kinora::language
