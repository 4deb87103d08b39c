#pragma once

#include "rubicon/time.hpp"
