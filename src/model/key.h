#pragma once

#include "rubicon/key.hpp"
