#pragma once

#include "rubicon/result.hpp"
