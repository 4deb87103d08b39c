#pragma once

#include "rubicon/tuple.hpp"
