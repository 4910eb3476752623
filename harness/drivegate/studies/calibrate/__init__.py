"""The motor derived anew from the published facts."""
