"""From a logged motion to a servo model: excitation, frequency response, fits with their uncertainty."""
