// Dictionaries of the language: dict_find, dict_next and dict_value over XML text or files, queried by XPath. One
// object a renderer; any thread may call (a lock: these are call-outs, made for setup, not for inner loops).
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace kinora::language {

class Dictionary {
 public:
  // `report` takes each problem once: a text that is no XML, a query that is no XPath.
  explicit Dictionary(std::function<void(const std::string&)> report = {});
  ~Dictionary();
  // The first node that a query finds in a dictionary: XML text, or the name of a file that ends with ".xml". 0:
  // none; -1: no valid dictionary.
  int find(std::string_view textOrFile, std::string_view query);
  int find(int node, std::string_view query);  // below a node
  int next(int node);                          // the next node that the same query found, or 0
  // The value of an attribute, or of the node itself for an empty name. False, and nothing written, where there is
  // none or its text does not hold `count` numbers.
  bool value(int node, std::string_view attribute, std::string& result);
  bool value(int node, std::string_view attribute, int32_t* result, int count);
  bool value(int node, std::string_view attribute, float* result, int count);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinora::language
