"""Study `fleet-leaks`: slow leaks of real trailers' tyres, each judged true or false."""
