// A message of the odd types, with a child of its own kind.
#pragma once

#include "libs/schema/schema.hpp"
#include "odd/tree_t.hpp"

namespace fusion_slam {

const Schema& odd_schema();  // from odd.lcm (parser_test.cpp)

inline odd::tree_t odd_leaf(std::int16_t n, std::int16_t m) {
  odd::tree_t tree;
  tree.n = n;
  tree.m = m;
  tree.matrix.assign(static_cast<std::size_t>(n),
                     std::vector<float>(static_cast<std::size_t>(m), 1.5F));
  tree.cube.assign(static_cast<std::size_t>(n),
                   std::vector<std::vector<float>>(2, std::vector<float>(3, -2.0F)));
  tree.inner.resize(static_cast<std::size_t>(m));
  for (auto& row : tree.inner) {
    row.resize(2);
    row[0].name = "first";
    row[1].words[1] = "word";
    row[0].last = row[1].last = -3;
  }
  for (auto& value : tree.hex_sized) value = 200;
  tree.n_children = 0;
  tree.nothing.resize(static_cast<std::size_t>(n));
  return tree;
}

inline odd::tree_t odd_tree() {
  odd::tree_t tree = odd_leaf(2, 3);
  tree.n_children = 2;
  tree.children = {odd_leaf(1, 1), odd_leaf(3, 2)};
  return tree;
}

}  // namespace fusion_slam
